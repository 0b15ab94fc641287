"""Neighbours' predictions are followed, age into what is known without them, and widen their downwash."""

import tracemalloc

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.neighbours.constant_velocity import FAR, Neighbours, at_constant_velocity
from q2q_control.mpc.neighbours.exchanged_paths import (
    LATE_FADE,
    MOST_POSITIONS,
    SILENT,
    TRACKING,
    PredictedPaths,
    ReceivedPath,
    ReceivedPredictions,
    accelerations_along,
    blend,
    known_neighbours,
    positions_at,
)
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, Others, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.jet import MEASURED_LAW, Jet
from q2q_model.signals.cdr.cdr_head import MOST_VEHICLES
from q2q_model.signals.values import Array, CommandStatus, SwarmSetpoint, SwarmState, TrackStatus
from q2q_model.tunable import tunable_of
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

PERIOD = 0.1
STEP, STAGES = 0.05, 20
TIMES = 1.0 + STEP * np.arange(STAGES + 1)


def prediction(t: float, slope: float = 1.0, name: str = "cf2") -> PredictedPaths:
    """Return a vehicle that moves along y at `slope` [m/s]; it is at 0 at t + 0.02 [s]."""
    pos = np.zeros((1, STAGES + 1, 3), np.float32)
    pos[0, :, 1] = slope * STEP * np.arange(STAGES + 1)
    return PredictedPaths(t, (name,), t + 0.02, STEP, pos)


def known(x: float = 0.5) -> Neighbours:
    """Return cf2 as known without predictions: at rest at x [m]."""
    path = np.tile([x, 0.0, 0.0], (1, STAGES + 1, 1))
    return Neighbours(("cf2",), path[:, 0], path, np.zeros((1, STAGES, 3)), np.array([TRACKING]))


def neighbours(received: ReceivedPredictions, t: float, known: Neighbours) -> Neighbours:
    """Return what a tick at t [s] takes cf2 to do."""
    followed, share = received.follow(t, known._replace(spread=np.zeros(1)), TIMES)
    return blend(followed, known, share)


def test_a_path_is_interpolated_at_the_receivers_stages_and_goes_on_straight_after_its_end() -> None:
    received = prediction(t=0.97)
    path = np.empty((STAGES + 1, 3))
    positions_at(
        ReceivedPath(received.t, received.start, received.step, received.pos[0].astype(np.float64)),
        TIMES + 0.5,
        path,
    )
    assert path[:, 1] == pytest.approx(TIMES + 0.5 - 0.99, abs=1e-6)  # float32
    assert TIMES[-1] + 0.5 > received.start + STAGES * STEP


def test_a_path_has_the_acceleration_of_its_parabola() -> None:
    acc = np.array([0.5, -2.0, 1.0])
    path = 0.3 + 0.5 * acc * (TIMES[:, None] - 1.2) ** 2
    assert accelerations_along(path[None], TIMES)[0] == pytest.approx(np.tile(acc, (STAGES, 1)))


@pytest.mark.parametrize("age", [0.01, PERIOD])
def test_a_prediction_that_no_newer_one_was_due_to_replace_is_followed_without_spread(age: float) -> None:
    received = ReceivedPredictions(PERIOD)
    received.receive(prediction(t=0.9))
    found = neighbours(received, 0.9 + age, known())
    assert found.path[0, :, 1] == pytest.approx(TIMES - 0.92, abs=1e-6)  # float32
    assert found.path[0, :, 0] == pytest.approx(0.0, abs=1e-12)
    assert found.spread[0] == 0.0
    late = neighbours(received, 0.9 + 2.0 * PERIOD, known())
    assert late.spread[0] > 0.3 * TRACKING


def test_a_followed_vehicles_thrust_is_that_of_its_paths_curvature() -> None:
    pos = np.zeros((1, STAGES + 1, 3), np.float32)
    pos[0, :, 0] = 0.5 * 2.0 * (STEP * np.arange(STAGES + 1)) ** 2
    received = ReceivedPredictions(PERIOD)
    received.receive(PredictedPaths(0.98, ("cf2",), 1.0, STEP, pos))
    found = neighbours(received, 1.0, known())
    assert found.inputs[0, :, 0] == pytest.approx(2.0, abs=1e-3)  # float32 over STEP squared


def test_of_a_tick_to_come_nothing_is_used_yet() -> None:
    received = ReceivedPredictions(PERIOD)
    received.receive(prediction(t=0.98, slope=9.0))
    received.receive(prediction(t=0.97))
    assert neighbours(received, 0.98, known()).path[0, -1, 1] < 1.1
    assert neighbours(received, 0.99, known()).path[0, -1, 1] > 5.0


def test_a_late_prediction_turns_into_what_is_known_and_its_spread_into_the_trackings() -> None:
    received = ReceivedPredictions(PERIOD)
    received.receive(prediction(t=0.5))
    late = PERIOD + LATE_FADE
    found = neighbours(received, 0.5 + late, known(x=1.0))
    share = np.exp(-1.0)
    assert found.path[0, :, 0] == pytest.approx(1.0 - share, abs=1e-5)
    assert found.spread[0] == pytest.approx((1.0 - share) * TRACKING, abs=1e-5)
    lost = neighbours(received, 20.0, known(x=1.0))
    assert lost.path[0] == pytest.approx(known(x=1.0).path[0], abs=1e-9)


def test_after_a_clock_is_set_back_predictions_count_again() -> None:
    received = ReceivedPredictions(PERIOD)
    for t in (50.0, 50.01, 0.5):
        received.receive(prediction(t))
    assert neighbours(received, 0.51, known()).spread[0] == 0.0


@pytest.mark.parametrize("slope", [np.nan, np.inf])
def test_a_prediction_that_is_no_number_is_refused(slope: float) -> None:
    with pytest.raises(ValueError, match="prediction of cf2 is not finite"), np.errstate(invalid="ignore"):
        prediction(0.5, slope)


@pytest.mark.parametrize(
    ("start", "step"), [(0.5, 1e-300), (-1e18, 0.05), (1e3, 0.05), (np.nan, 0.05), (0.5, np.inf), (0.5, 0.0)]
)
def test_a_prediction_whose_steps_cannot_be_counted_is_refused(start: float, step: float) -> None:
    """The number of steps to a time overflowed, and the kernel read beyond its positions."""
    with pytest.raises(ValueError, match="start must be within 100 s of t"):
        PredictedPaths(0.5, ("cf2",), start, step, np.zeros((1, 4, 3), np.float32))


def test_a_prediction_of_a_name_given_twice_or_of_places_out_of_reach_is_refused() -> None:
    pos = np.zeros((2, 4, 3), np.float32)
    with pytest.raises(ValueError, match="duplicate vehicle names in cf2, cf2"):
        PredictedPaths(0.5, ("cf2", "cf2"), 0.52, 0.05, pos)
    pos[1, 2, 0] = -3e38
    with pytest.raises(ValueError, match=r"prediction of cf2, cf3: positions must be within 1e\+06 m"):
        PredictedPaths(0.5, ("cf2", "cf3"), 0.52, 0.05, pos)


def test_without_predictions_a_neighbour_is_on_its_reference_and_a_lost_one_far_away() -> None:
    names, flag = ("cf1", "cf2", "cf3", "cf4"), np.zeros(4, np.uint8)
    flag[3] = TrackStatus.LOST
    pos, vel = np.arange(12.0).reshape(4, 3), np.tile([0.0, 1.0, 0.0], (4, 1))
    state = SwarmState(1.0, names, pos, vel, np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)), vel, np.zeros(4), flag)
    two = np.zeros((2, 3))
    given = resting_setpoint(1.0, ("cf2", "cf1"), two, status=flag[:2])
    references = np.full((2, STAGES + 1, 9), 7.0)
    found = known_neighbours(at_constant_velocity(state, ("cf1",), TIMES), given, references)
    assert found.names == ("cf2", "cf3", "cf4")
    assert (found.path[0] == 7.0).all()
    assert found.path[1, :, 1] == pytest.approx(7.0 + TIMES - 1.0)
    assert np.abs(found.path[2]).min() >= FAR
    assert found.spread.tolist() == [TRACKING, TRACKING, 0.0]


def empty_setpoint(t: float) -> SwarmSetpoint:
    """Return a setpoint without vehicles."""
    none = np.zeros((0, 3))
    return resting_setpoint(t, (), none)


def hovering(t: float) -> SwarmState:
    """Return cf1 below cf2, at rest."""
    pos = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]])
    return resting_state(t, ("cf1", "cf2"), pos)


def test_where_the_setpoint_names_nobody_a_neighbour_moves_on_at_constant_velocity() -> None:
    straight = at_constant_velocity(hovering(1.0), ("cf1",), TIMES)
    found = known_neighbours(straight, empty_setpoint(1.0), np.zeros((0, STAGES + 1, 9)))
    assert np.array_equal(found.path, straight.path)
    assert np.array_equal(found.inputs, straight.inputs)
    assert found.spread.tolist() == [TRACKING]


def test_a_setpoint_that_names_nobody_gives_a_distributed_controller_what_it_gives_any() -> None:
    """It ended in an IndexError; without a setpoint the vehicle is held, then level at its hover thrust."""
    setups = MpcSetup(vehicles=("cf1",), exchange_period=PERIOD), MpcSetup(vehicles=("cf1",))
    distributed, alone = (Mpc(MpcParams(), CRAZYFLIE_2_0, MEASURED_LAW, setup) for setup in setups)
    for k in range(15):
        t = 0.01 * k
        given = hovering(t), empty_setpoint(t), None
        one, other = distributed.update(*given), alone.update(*given)
        assert (one.names, one.status.tolist()) == (other.names, other.status.tolist())
        assert one.thrust.tolist() == other.thrust.tolist() == [CRAZYFLIE_2_0.hover_thrust]
        assert one.pitch.tolist() == other.pitch.tolist() == [0.0]
    assert one.status.tolist() == [CommandStatus.LEVEL]


def downwash_below(x: float, spread: float, jet: Jet) -> Array:
    """Return eta_z of a vehicle at rest whose source hovers 0.5 m above it and x [m] aside, (N,)."""
    pos = np.zeros((STAGES + 1, 2, 3))
    pos[:, 1] = x, 0.0, 0.5
    tracks = Tracks(TIMES, pos, np.tile([0.0, 0.0, 1.0], (2, STAGES, 1)), np.ones((2, STAGES)), 0)
    others = Others(1, np.array([0.0, spread]))
    return predict_downwash(jet, tracks, GradientRule((2,), 100.0), others).eta[0, :, 2]


def test_the_downwash_of_an_uncertain_source_is_its_mean_over_a_normal_distribution() -> None:
    jet = Jet(strength=2.5, reference_gap=0.5, width=0.1, spread=0.0, upper_ratio=0.0)
    sigma = 0.05
    for x in (0.0, 0.05, 0.1, 0.2):
        # two Gaussians convolved in the plane: width^2 grows by sigma^2, the peak falls by their ratio
        wide = 0.1**2 + sigma**2
        exact = -2.5 * 0.1**2 / wide * np.exp(-(x**2) / (2.0 * wide))
        assert downwash_below(x, sigma, jet) == pytest.approx(exact, abs=0.007)  # quadrature: 0.3 % of 2.0
        assert abs(downwash_below(x, 0.0, jet)[0] - exact) > 0.06  # nine times that; 0.065 at 0.2 m


def state_of(t: float, *names: str) -> SwarmState:
    """Return vehicles at rest at the origin."""
    return resting_state(t, names, np.zeros((len(names), 3)))


def test_a_neighbour_is_silent_once_several_of_its_predictions_are_missing() -> None:
    received, names = ReceivedPredictions(PERIOD), ("cf1", "cf2", "cf3")
    assert received.silent(state_of(100.0, *names)) == ()  # no prediction has come yet
    received.receive(prediction(1.0))
    received.receive(prediction(1.3, name="cf3"))
    assert received.silent(state_of(1.0 + 0.99 * SILENT * PERIOD, *names)) == ()
    late = state_of(1.0 + 1.01 * SILENT * PERIOD, *names)
    assert received.silent(late) == ("cf2",)
    assert received.silent(state_of(late.t, "cf1", "cf3")) == ()  # nothing of cf2 is needed
    received.receive(prediction(1.5))
    assert received.silent(late) == ()


def test_names_that_change_are_forgotten_but_those_heard_last() -> None:
    received, first = ReceivedPredictions(PERIOD), 1.0
    received.receive(prediction(first, name="cf2"))
    for k in range(MOST_VEHICLES + 5):
        received.receive(prediction(first, name=f"other{k}"))
        if k == 10:
            received.receive(prediction(first + PERIOD, name="cf2"))
    kept = [k for k in range(MOST_VEHICLES + 5) if received.has(f"other{k}", first)]
    assert kept == list(range(6, MOST_VEHICLES + 5))
    assert received.has("cf2", first + PERIOD)


def test_a_prediction_that_is_kept_keeps_none_of_the_others_of_its_message() -> None:
    """Each of 200 messages has a name of its own, beside 99 that the next one has, too."""
    received, bytes_of_path = ReceivedPredictions(PERIOD), MOST_POSITIONS * 3 * 8
    others = tuple(f"cf{k}" for k in range(99))
    pos = np.zeros((100, MOST_POSITIONS, 3), np.float32)
    tracemalloc.start()
    try:
        for k in range(200):
            received.receive(PredictedPaths(1.0 + PERIOD * k, (*others, f"other{k}"), 1.0, STEP, pos))
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    paths = 2 * len(others) + 200
    assert held < 1.5 * paths * bytes_of_path  # 50 times that with all paths of each message


def test_a_prediction_that_is_too_large_is_refused() -> None:
    assert tunable_of(MpcParams.__dataclass_fields__["steps"]).high == MOST_POSITIONS - 1
    with pytest.raises(
        ValueError, match=r"positions \(1, 402, 3\) of 1 vehicles; must be \(n, 2 to 401, 3\)"
    ):
        PredictedPaths(0.5, ("cf2",), 0.52, 0.05, np.zeros((1, MOST_POSITIONS + 1, 3), np.float32))
    names = tuple(f"cf{k}" for k in range(MOST_VEHICLES + 1))
    with pytest.raises(ValueError, match="prediction of 10001 vehicles; must be at most 10000"):
        PredictedPaths(0.5, names, 0.52, 0.05, np.zeros((len(names), 2, 3), np.float32))
