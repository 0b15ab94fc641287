"""Learning of the contenders' downwash model, from flights other than those of the ablation.

Pairs of Crazyflies in the room `real`, in the wake of the case: one hovers, one passes over it at 0.3 to 1 m,
along other lines and at other speeds than in any case, and the controller ignores the downwash. The jet is
fitted to accelerometers, commands and positions as in `identify` (downwash_force, jet_fit); whether the air
keeps its source's motion is chosen on a held-out flight. The thrust lag is known: the room's latency and the
rotors' lag. A stack of three then shows whether the downwash of a vehicle grows with its thrust, as by
momentum theory but not in the paper (q2q_model.identification.force.loading).
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.flights.flight import Flight
from q2q_model.identification.force.downwash_force import ForceSamples, force_samples, score
from q2q_model.identification.force.jet_fit import JetForm, fit_to_pushes
from q2q_model.identification.force.loading import loading_of, usable_loading
from q2q_model.identification.force.recorded_force import push_of_sensors
from q2q_model.identification.intervals import Interval
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library

PAIRS = 3
"""Pairs in a training flight."""
FLIGHTS = 3
"""Training flights of pairs; the last is held out."""
FORMS = (JetForm(carried=0.0), JetForm(carried=1.0))
"""Candidate models."""
DURATION = 30.0
"""[s]"""
FIRST_SEED = 1000
"""First seed of training flights; those of the ablation start at 0."""


@dataclass(frozen=True, slots=True)
class Learned:
    """Model and gains learned in one wake."""

    model: InteractionModel
    loading: float
    """Fraction of a source's thrust beyond its weight that strengthens its downwash [-]."""
    r2: float | None
    """On the downwash of the held-out flight."""
    loading_interval: Interval | None = None
    """95 % interval from the stack of three; the loading is 0 if it contains 0."""


def learn(wake: str) -> Learned:
    """Return the model learned in a wake."""
    flown = [_flown(pairs_over(k), wake, FIRST_SEED + k) for k in range(FLIGHTS)]
    pushes = [_pushes(flight) for flight in flown]
    taught, left_out = [one for flight in pushes[:-1] for one in flight], pushes[-1]
    trials = [(score(fit_to_pushes(taught, form).jet, left_out).r2_exposed, form) for form in FORMS]
    r2, form = max(trials, key=lambda trial: -np.inf if trial[0] is None else trial[0])
    model = fit_to_pushes([*taught, *left_out], form).jet
    stack = _flown(stack_of_three(), wake, FIRST_SEED + FLIGHTS)
    loading = loading_of(model, [one for one in _pushes(stack) if one.vehicle == 0])
    return Learned(model, usable_loading(loading), r2, loading)


def pairs_over(number: int) -> tuple[VehicleWaypoints, ...]:
    """Return the vehicles of a training flight: pairs 10 m apart, each with its own gap, line and speed."""
    vehicles = []
    for pair in range(PAIRS):
        k = PAIRS * number + pair
        gap, aside, turn, wait = 0.3 + 0.085 * k, 0.02 * (k % 4), 0.7 * k, 3.0 * (k % 2)
        reach = 0.25 - 0.1 * (k % 3)
        line = [(0.0, -1.0), (5.0, -1.0), (13.0, reach), (14.0 + wait, reach), (23.0, 1.0), (27.0, -1.0)]
        over = [Waypoint(t, _beside(10.0 * pair, (along, aside), turn, 1.0 + gap)) for t, along in line]
        below = Waypoint(0.0, (10.0 * pair, 0.0, 1.0))
        vehicles += [_to_the_end(f"lower{pair}", [below]), _to_the_end(f"upper{pair}", over)]
    return tuple(vehicles)


def stack_of_three() -> tuple[VehicleWaypoints, ...]:
    """Return two vehicles that pass in turn under a third."""
    low = [(0.0, -1.0), (8.0, -1.0), (14.0, 0.0), (18.0, 0.0), (24.0, 1.0)]
    mid = [(0.0, -1.0), (4.0, -1.0), (10.0, 0.0), (21.0, 0.0), (27.0, 1.0)]
    return (
        _to_the_end("low", [Waypoint(t, (along, 0.03, 0.9)) for t, along in low]),
        _to_the_end("mid", [Waypoint(t, (0.0, along, 1.35)) for t, along in mid]),
        _to_the_end("top", [Waypoint(0.0, (0.0, 0.0, 1.9))]),
    )


def _pushes(flight: Flight) -> list[ForceSamples]:
    base = library.load("stack3")
    lag = base.vicon.latency + base.radio.latency + base.vehicle.thrust_lag
    found = push_of_sensors(flight, base.vehicle, lag)
    return [] if found is None else force_samples(found)


def _flown(vehicles: tuple[VehicleWaypoints, ...], wake: str, seed: int) -> Flight:
    base = library.load("stack3")
    scenario = replace(base, wake=wake, model="none", duration=DURATION, waypoints=vehicles)
    return fly(scenario, FlightOptions(mode="ignoring", seed=seed))


def _to_the_end(name: str, points: list[Waypoint]) -> VehicleWaypoints:
    """Return a vehicle that hovers at its last waypoint until the end of the flight."""
    return VehicleWaypoints(name, (*points, replace(points[-1], t=DURATION)))


def _beside(
    middle: float, place: tuple[float, float], turn: float, height: float
) -> tuple[float, float, float]:
    """Return the point `along` and `aside` [m] of a line through (middle, 0), rotated by `turn` [rad]."""
    (along, aside), c, s = place, float(np.cos(turn)), float(np.sin(turn))
    return middle + along * c - aside * s, along * s + aside * c, height
