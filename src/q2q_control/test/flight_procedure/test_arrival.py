"""Vehicles arrive, each by itself, in the air of a room; what drifts, circles, swings or is lost does not."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from procedure_bench import STEP, WELL

from q2q_control.flight_procedure.checks.arrival import LOST_S, Arrival, above, on_the_ground
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_model.signals.values import Array

PARAMS, LANDING = FlightProcedureParams(), LandingParams()
HEIGHT = PARAMS.take_off_height
PATIENCE = PARAMS.step_timeout_s
Motion = Callable[[float], Array]
"""Offsets of vehicles from their places [m] at a time [s], (n, 3)."""


@dataclass
class Hover:
    """Vehicles that are to rest at a height, or on the ground, 1 m apart."""

    motion: Motion
    arrival: Arrival = field(default_factory=lambda: Arrival(PARAMS, LANDING))
    age: Array = field(default_factory=lambda: np.zeros(1))
    seen: Array = field(default_factory=lambda: np.full((1, 3), np.nan))
    """Last measured positions [m], (n, 3)."""
    t: float = 0.0
    height: float = HEIGHT

    def step(self, *, unmeasured: Array | None = None) -> str:
        """Let a tick pass, in which some vehicles are not measured; return why they have not arrived."""
        self.t += STEP
        off, vel = self.motion(self.t), (self.motion(self.t) - self.motion(self.t - 1e-6)) / 1e-6
        places = np.column_stack([np.arange(len(off)), np.zeros(len(off)), np.full(len(off), self.height)])
        unmeasured = np.zeros(len(off), dtype=np.bool_) if unmeasured is None else unmeasured
        self.age = np.where(unmeasured, self.age + STEP, 0.0)
        self.seen = np.where(unmeasured[:, None], self.seen, places + off)
        names = tuple(replace(WELL, name=f"cf{row}") for row in range(len(off)))
        nan = np.full_like(off, np.nan)
        observation = Observation(names, self.seen, vel, self.age, nan, nan, 0.0, None)
        goal = above(places, PARAMS) if self.height else on_the_ground(observation, PARAMS)
        return self.arrival.update(observation, goal, self.t)

    def arrives_in(self, seconds: float) -> float:
        """Return when all have arrived [s]; infinite if they have not in time."""
        while self.t < seconds:
            if not self.step():
                return self.t
        return np.inf


def room(count: int, seed: int = 0) -> Motion:
    """Return motions of hovering vehicles as in the air `room`: their median speed is 0.075 m/s.

    Sums of sinusoids of 0.3 to 0.9 Hz; recorded hovers are 2.1 cm (median) from their places.
    """
    rng = np.random.default_rng(seed)
    rate = 2.0 * np.pi * rng.uniform(0.3, 0.9, (6, count, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (6, count, 3))
    size = rng.normal(0.0, 0.0089, (6, count, 3)) * [1.0, 1.0, 0.5]
    return lambda t: np.asarray((size * np.sin(rate * t + phase)).sum(axis=0))


def speeds(motion: Motion) -> Array:
    """Return the speeds of 5 s [m/s], (T, n)."""
    times = np.arange(0.0, PATIENCE, STEP)
    return np.array([np.linalg.norm(motion(t + 1e-4) - motion(t), axis=1) / 1e-4 for t in times])


@pytest.mark.parametrize("count", [2, 7, 30, 100])
def test_vehicles_that_hold_their_places_in_the_air_of_a_room_arrive(count: int) -> None:
    took = [Hover(room(count, seed)).arrives_in(PATIENCE) for seed in range(5)]
    assert max(took) < PATIENCE, took
    assert min(took) > PARAMS.settle_s - STEP


def test_in_that_air_seven_vehicles_are_never_slow_together_for_long() -> None:
    """So an instant at which all are slow is no condition."""
    slow = [(speeds(room(7, seed)) < PARAMS.still_speed).all(axis=1) for seed in range(5)]
    assert np.median([speeds(room(7, seed)) for seed in range(5)]) == pytest.approx(0.075, abs=0.01)
    needed = round(0.5 / STEP)
    assert max(np.convolve(one, np.ones(needed), "valid").max() for one in slow) < needed


def along_x(offset: Callable[[float], float]) -> Motion:
    """Return the motion of three vehicles, of which the second moves along x."""
    return lambda t: np.array([[0.0, 0.0, 0.0], [offset(t), 0.0, 0.0], [0.0, 0.0, 0.0]])


def in_a_circle(radius: Callable[[float], float], hertz: float) -> Motion:
    """Return the motion of three vehicles, of which the second circles."""

    def motion(t: float) -> Array:
        angle = 2.0 * np.pi * hertz * t
        return np.array(
            [np.zeros(3), [radius(t) * np.cos(angle), radius(t) * np.sin(angle), 0.0], np.zeros(3)]
        )

    return motion


MOVING = {
    "drifts": along_x(lambda t: 0.11 * t - 0.14),
    "sinks": lambda t: np.array([np.zeros(3), [0.0, 0.0, 0.14 - 0.11 * t], np.zeros(3)]),
    "circles": in_a_circle(lambda _: 0.06, 0.5),
    "circles slowly": in_a_circle(lambda _: 0.14, 0.2),
    "circles in settle_s": in_a_circle(lambda _: 0.06, 1.0 / PARAMS.settle_s),
    "vibrates": along_x(lambda t: 0.02 * np.sin(2.0 * np.pi * 3.0 * t)),
    "circles ever wider": in_a_circle(lambda t: 0.04 * np.exp(0.3 * t), 1.0),
    "swings": along_x(lambda t: 0.06 * np.sin(2.0 * np.pi * t / PARAMS.settle_s)),
}


@pytest.mark.parametrize("motion", MOVING.values(), ids=MOVING)
def test_a_vehicle_that_moves_does_not_arrive(motion: Motion) -> None:
    hover = Hover(motion)
    assert hover.arrives_in(PATIENCE) == np.inf
    assert hover.step().startswith("cf1 ")


def swing(axis: int, amplitude: float, period: float, phase: float) -> Motion:
    """Return the motion of a vehicle that swings along an axis."""
    along = np.eye(3)[[axis]]
    return lambda t: along * amplitude * np.sin(2.0 * np.pi * t / period + phase)


def circle(radius: float, period: float, phase: float) -> Motion:
    """Return the motion of a vehicle that circles."""
    first, second = swing(0, radius, period, phase), swing(1, radius, period, phase + 0.5 * np.pi)
    return lambda t: np.asarray(first(t) + second(t))


FAST_OR_FAR = [(0.1, 1.5), (0.14, 2.0), (0.14, 2.75), (0.2, 4.0), (0.3, 3.0), (0.6, 6.0)]
"""Amplitudes [m] and periods [s] of swings that reach more than 0.31 m/s."""


@pytest.mark.parametrize(("amplitude", "period"), FAST_OR_FAR)
def test_no_vehicle_that_swings_fast_or_out_of_its_tolerance_arrives(amplitude: float, period: float) -> None:
    """Its turning points, where it is slow, are no rest; the other four phases are mirrored."""
    for phase in np.linspace(0.0, np.pi, 4, endpoint=False):
        motions = [swing(0, amplitude, period, phase), swing(2, amplitude, period, phase)]
        motions.append(circle(amplitude, period, phase))
        for motion in motions:
            assert Hover(motion).arrives_in(0.75 * period) == np.inf, phase


STILL_MOVES = "cf1 still moves: it has stayed within 0.1 m of one place and below 0.25 m/s for 0.0"


def test_a_vehicle_that_vibrates_after_its_rest_has_not_arrived_when_the_last_does() -> None:
    def motion(t: float) -> Array:
        off = np.zeros((3, 3))
        off[1, 0] = 0.05 * np.sin(2.0 * np.pi * 3.0 * (t - 2.0)) if t > 2.0 else 0.0
        off[2, 2] = -0.4 if t < 3.0 else 0.0
        return off

    hover = Hover(motion)
    assert hover.arrives_in(1.5) == np.inf
    assert hover.step() == "cf2 is at 0.10 m, 0.40 m from its goal"  # cf0 and cf1 rest
    assert hover.arrives_in(PATIENCE) == np.inf
    assert hover.step().startswith(STILL_MOVES)


def test_a_vehicle_that_circles_ever_wider_after_its_rest_has_not_arrived_when_the_last_does() -> None:
    circle = in_a_circle(lambda t: 0.005 * np.exp(0.9 * t), 1.0)

    def motion(t: float) -> Array:
        below = -0.4 if t < 3.0 else 0.0
        return np.asarray(circle(t) + np.array([np.zeros(3), np.zeros(3), [0.0, 0.0, below]]))

    hover = Hover(motion)
    assert hover.arrives_in(1.5) == np.inf
    assert hover.step() == "cf2 is at 0.10 m, 0.40 m from its goal"  # cf0 and cf1 rest
    assert hover.arrives_in(3.5) == np.inf
    assert hover.step().startswith(STILL_MOVES)


def test_short_gaps_of_motion_capture_do_not_interrupt_rests() -> None:
    hover = Hover(lambda _: np.zeros((7, 3)))
    gap = round(0.2 / STEP)  # [ticks]
    away = [np.arange(7) == (tick // gap) % 7 for tick in range(round(2.0 / STEP))]  # one after the other
    reasons = [hover.step(unmeasured=one) for one in away]
    needed = round(PARAMS.settle_s / STEP)
    assert reasons.index("") <= needed + gap
    assert not any(reasons[reasons.index("") :])


def test_no_rest_is_completed_while_a_vehicle_is_not_measured() -> None:
    hover, second = Hover(lambda _: np.zeros((2, 3))), np.array([False, True])
    for _ in range(round(0.8 / STEP)):
        hover.step()
    reasons = [hover.step(unmeasured=second) for _ in range(round(0.4 / STEP))]
    assert all(reasons)
    assert reasons[-1] == "cf1 has no state younger than 0.1 s (its last is 0.40 s old): check motion capture"


@pytest.mark.parametrize("settle_s", [PARAMS.settle_s, 3.0])
def test_a_vehicle_that_is_lost_for_good_has_not_arrived(settle_s: float) -> None:
    arrival = Arrival(replace(PARAMS, settle_s=settle_s), LANDING)
    hover, second = Hover(lambda _: np.zeros((2, 3)), arrival), np.array([False, True])
    assert hover.arrives_in(5.0) < 5.0
    reasons = [hover.step(unmeasured=second) for _ in range(round(1.0 / STEP))]
    held = round(LOST_S / STEP)
    assert not any(reasons[: held - 1])
    assert all(one.startswith("cf1 has no state younger than 0.1 s") for one in reasons[held + 1 :])


def test_vehicles_that_sink_slowly_through_the_last_centimetres_have_not_landed() -> None:
    """As at the end of a landing's polynomial; their motors were stopped 2 cm above the ground."""
    height = Polynomial([1.0, 0.0, 0.0, -10.0, 15.0, -6.0])

    def motion(t: float) -> Array:
        return np.array([[0.0, 0.0, HEIGHT * height(min(t / LANDING.landing_duration_min, 1.0))]] * 2)

    landed = Hover(motion, height=0.0).arrives_in(LANDING.landing_duration_min + 1.0)
    assert LANDING.landing_duration_min <= landed <= LANDING.landing_duration_min + PARAMS.settle_s


@pytest.mark.parametrize("settle_s", [0.5, 1.0])
@pytest.mark.parametrize("speed", [0.1, 0.2, 0.4])
def test_no_landing_is_complete_during_the_descent(speed: float, settle_s: float) -> None:
    """The shortest settle_s: motors were stopped at 0.10 m and 0.28 m/s without one."""
    arrival = Arrival(replace(PARAMS, settle_s=settle_s), LANDING)
    down = HEIGHT / speed
    landed = Hover(lambda t: np.array([[0.0, 0.0, max(HEIGHT - speed * t, 0.0)]]), arrival, height=0.0)
    assert down < landed.arrives_in(down + 2.0) <= down + settle_s + STEP


@pytest.mark.parametrize(("noise", "seconds"), [(0.001, 1.1), (0.003, 1.1), (0.005, 4.0)])
def test_a_hundred_standing_vehicles_have_landed_despite_noise(noise: float, seconds: float) -> None:
    rng = np.random.default_rng(0)
    arrival, tight = Arrival(PARAMS, LANDING), replace(PARAMS, near_ground=0.03)
    names, still = tuple(replace(WELL, name=f"cf{row}") for row in range(100)), np.zeros((100, 3))
    reasons = []
    for tick in range(round(seconds / STEP)):
        pos = rng.normal(0.0, noise, (100, 3))
        seen = Observation(names, pos, still, np.zeros(100), still, still, 0.0, None)
        reasons.append(arrival.update(seen, on_the_ground(seen, tight), tick * STEP))
    assert "" in reasons
