"""Flight of a random encounter with full dynamics, under the safe replanner.

The paths are those of `q2q_planner.experiments.random_encounters`. Radio latency and loss are drawn again for
each encounter; the rest is the room `real`. Controllers and the air share neither flights nor family: the
model is `measured_law`, fitted to the flights dc19, the air is learned from dc21.
"""

from dataclasses import asdict, dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.zone import Cylinder
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, SetpointStatus
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_planner.experiments.encounter_verdict import CLEAR, NEAR
from q2q_planner.experiments.random_encounters import random_encounter
from q2q_planner.experiments.replanned_encounter import AFTERWARDS
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.plan_playback.plan_waypoints import waypoints_of
from q2q_sim.campaigns.random_runs.random_run import GAINS as INTEGRAL_GAINS
from q2q_sim.experiments.promise.fastest_return import can_return
from q2q_sim.experiments.promise.tracking_tube import TubeConditions
from q2q_sim.loop.closed_loop import FlightOptions, answered_ticks
from q2q_sim.scenarios.room_profiles import REAL
from q2q_sim.scenarios.scenario import Scenario

MODEL = "measured_law"
GAINS = {name: gain for name, gain in INTEGRAL_GAINS.items() if not name.startswith("k_i")}
"""Of the real flights."""
LEAST_LATENCY, MOST_LATENCY = 0.006, 0.026
"""Range of the radio's latency [s], about the 16 ms of the room `real`; the camera adds its own."""
DRAWS = 50
"""Most draws of paths until vehicles start apart."""
MOST_LOSS = 0.1
"""Largest share of lost commands, that of `random_encounter`."""
BETWEEN = 4
"""Straight parts of a tick in which distances are taken: vehicles turn by less than 0.1 mm within a tick."""
STEADY = SafeReplannerParams(
    jerk_max=20.0, speed_max=2.5, tracking=0.12, tracking_z=0.12, grace=0.35, approach=4.0
)
"""Motions of bounded jerk with the fastest poles that it follows, and a first guess of the tube, which
flights replace. The tube covers the drift in their gaps: the longest, `dropout_max` of the room, and what
latencies and ticks add."""


@dataclass(frozen=True, slots=True)
class PromiseCase:
    """What is flown: controller, air and replanner."""

    params: SafeReplannerParams = STEADY
    controller: str = "pid"
    air: str = "room"

    @property
    def conditions(self) -> TubeConditions:
        """Return the conditions of a tube that is learned from these flights."""
        bounds = self.params.speed_max, self.params.acc_max, self.params.jerk_max
        return TubeConditions(
            self.controller,
            MODEL,
            self.air,
            *bounds,
            REAL.vicon.latency + MOST_LATENCY,
            MOST_LOSS,
            REAL.vicon.dropout_max,
            self.params.approach,
            self.params.grace,
        )


@dataclass(frozen=True, slots=True)
class EncounterRecord:
    """Outcome of a flight."""

    seed: int
    vehicles: int
    apart_at_start: bool
    """See starts_apart."""
    horizontal: float
    """Largest tracking error of any vehicle [m]."""
    vertical: float
    """[m]"""
    clearance: float
    """Minimum signed distance of two vehicles to the zone [m]."""
    announced: bool
    """A vehicle of every pair in the zone had the status PROMISE_BROKEN; true if there is none."""
    ticks: int
    broken_ticks: int
    """Ticks in which some vehicle had it."""
    arrived: bool | None
    """All setpoints end within NEAR of the references, AFTERWARDS after the plan; None if these are in each
    other's zones."""
    in_reach: bool | None
    """They could, were each vehicle alone in the room from the end of the plan on; None as for `arrived`."""

    @property
    def entered(self) -> bool:
        """Return whether a vehicle entered a zone."""
        return self.clearance < 0.0


def fly_room_encounter(seed: int, case: PromiseCase) -> EncounterRecord:
    """Return the outcome of the encounter of a seed."""
    generator = np.random.default_rng(seed)
    for _ in range(DRAWS):
        encounter = random_encounter(generator, clear_by=case.params.with_tube.eps + CLEAR)
        if starts_apart(encounter.plan, case.params):
            break
    latency = float(generator.uniform(LEAST_LATENCY, MOST_LATENCY))
    scenario = encounter_scenario(encounter.plan, latency, encounter.loss, case)
    return _record(seed, scenario, encounter.plan, case)


def starts_apart(plan: SwarmPlan, params: SafeReplannerParams) -> bool:
    """Return whether zones and tubes are apart at the first tick: the condition that paths can break."""
    grown = params.with_tube
    return _distance(plan, 0.0, Cylinder(grown.eps, grown.d)) >= CLEAR


def _distance(plan: SwarmPlan, t: float, zone: Cylinder) -> float:
    """Return the least signed distance of two references to the zone at time t [m]."""
    pos = setpoint_at(plan, t).pos
    i, j = np.triu_indices(len(pos), 1)
    return float(zone.signed_distance(pos[i] - pos[j]).min(initial=np.inf))


def encounter_scenario(plan: SwarmPlan, latency: float, loss: float, case: PromiseCase) -> Scenario:
    """Return the scenario of a plan, with the radio's latency [s] and loss."""
    return Scenario(
        name="encounter",
        description="random encounter of Crazyflies in a real room",
        duration=round(plan.duration + AFTERWARDS, 2),
        vehicle=CRAZYFLIE_2_0,
        waypoints=waypoints_of(plan),
        plan=plan,
        air=case.air,
        model=MODEL,
        vicon=REAL.vicon,
        radio=replace(REAL.radio, latency=latency, loss=loss),
        imu=REAL.imu,
        disturbance=REAL.disturbance,
        overrides={"pid": GAINS, "safe_replanner": asdict(case.params)},
    )


class _Flown(NamedTuple):
    """What is judged of a flight."""

    t: Array
    """Ticks [s], (T,)."""
    true_pos: Array
    """[m], (T, n, 3)."""
    safe_pos: Array
    """Of the setpoints [m], (T, n, 3)."""
    safe_motion: Array
    """Their velocities [m/s] and accelerations [m/s^2], (T, n, 3, 2)."""
    broken: NDArray[np.bool_]
    """Which vehicles had the status PROMISE_BROKEN, (T, n)."""


def _flown(seed: int, scenario: Scenario, controller: str) -> _Flown:
    known = find_model(scenario.model).interaction
    options = FlightOptions(controller=controller, replan="safe", seed=seed, model=known)
    ticks = [
        (given.t, tick.truth.pos, given.pos, np.stack((given.vel, given.acc), axis=-1), given.status)
        for tick, given in (
            (tick, answer.reference_safe) for tick, answer in answered_ticks(scenario, options)
        )
    ]
    t, true_pos, safe_pos, motion, status = (np.array(column) for column in zip(*ticks, strict=True))
    return _Flown(t, true_pos, safe_pos, motion, status == SetpointStatus.PROMISE_BROKEN)


def _record(seed: int, scenario: Scenario, plan: SwarmPlan, case: PromiseCase) -> EncounterRecord:
    flown = _flown(seed, scenario, case.controller)
    announced = flown.broken
    error = flown.true_pos - flown.safe_pos
    zone = Cylinder(case.params.eps, case.params.d)
    i, j = np.triu_indices(len(scenario.names), 1)
    nearest = _nearest(flown.true_pos[:, i] - flown.true_pos[:, j], zone)
    inside = nearest < 0.0
    grown, end = case.params.with_tube, float(flown.t[-1])
    goal = setpoint_at(plan, end).pos
    clear = _distance(plan, end, Cylinder(grown.eps, grown.d)) > case.params.margin + CLEAR
    return EncounterRecord(
        seed=seed,
        vehicles=len(scenario.names),
        apart_at_start=starts_apart(plan, case.params),
        horizontal=float(np.hypot(error[..., 0], error[..., 1]).max()),
        vertical=float(np.abs(error[..., 2]).max()),
        clearance=float(nearest.min(initial=np.inf)),
        announced=bool((announced[:, i] | announced[:, j])[inside].all()),
        ticks=len(announced),
        broken_ticks=int(announced.any(axis=1).sum()),
        arrived=bool(np.abs(flown.safe_pos[-1] - goal).max() < NEAR) if clear else None,
        in_reach=can_return(_from_goals(flown, goal), AFTERWARDS, NEAR, case.params) if clear else None,
    )


def _from_goals(flown: _Flown, goal: Array) -> Array:
    """Return where setpoints are from their goals (n, 3), and how they move, AFTERWARDS before the end."""
    row = int(np.searchsorted(flown.t, flown.t[-1] - AFTERWARDS - 0.5 * TICK_S))
    return np.concatenate(((flown.safe_pos[row] - goal)[..., None], flown.safe_motion[row]), axis=-1)


def _nearest(rel_pos: Array, zone: Cylinder) -> Array:
    """Return the least signed distance of pairs (T, pairs, 3) from each tick to the next [m], (T, pairs)."""
    after = np.concatenate([rel_pos[1:], rel_pos[-1:]])
    shares = np.arange(BETWEEN) / BETWEEN
    parts = [zone.signed_distance(rel_pos + part * (after - rel_pos)) for part in shares]
    return np.asarray(np.min(parts, axis=0))
