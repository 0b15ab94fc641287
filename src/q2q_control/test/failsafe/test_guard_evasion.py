"""The guard moves measured vehicles out of the way of lost ones, and lost ones brake."""

from dataclasses import replace

import numpy as np
import pytest
from guarded_flights import (
    HOLD,
    HOVER,
    LEVEL,
    NAMES,
    OK,
    PARAMS,
    TICK,
    Scripted,
    guarded,
    setpoint_at,
    state_at,
)

from q2q_control.failsafe.tracking_loss.braking_law import BRAKING_MAX, BRAKING_S
from q2q_model.signals.values import (
    Interference,
    SwarmCommand,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY


def test_who_is_beneath_an_unseen_vehicle_evades_and_a_clock_set_back_moves_it_no_further() -> None:
    controller = Scripted(OK, OK)
    guard = guarded(controller)
    place = np.array([[0.7, 0.0, 1.0], [1.0, 0.0, 1.5]])

    def moved(t: float, age: float) -> float:
        """Return by how much cf1 is moved in x [m]; cf2, above it, was measured `age` ago."""
        controller.status = (OK, LEVEL if age > 0.35 else OK)
        state = replace(state_at(t, (0.0, age)), pos=place)
        guard.update(state, replace(setpoint_at(t), pos=place), None)
        return float(controller.given[-1].pos[0, 0]) - 0.7

    assert [moved(k * TICK, 0.0) for k in range(5)] == [0.0] * 5
    before = [moved(k * TICK, k * TICK - 0.04) for k in range(5, 100)][-1]
    answered = len(controller.given)
    assert before < -0.1
    after = [moved(k * TICK, 0.95) for k in range(60, 80)][-1]  # old ticks, until they have risen for long
    assert float(controller.given[answered].pos[0, 0]) - 0.7 == pytest.approx(before)
    assert after < before  # and on it goes


@pytest.mark.parametrize("statuses", [(OK,), (OK, HOLD)], ids=["of another controller", "held"])
def test_a_vehicle_evades_a_lost_one_as_soon_as_it_is_lost_until_that_is_cut(
    statuses: tuple[int, ...],
) -> None:
    controller = Scripted(*statuses)
    guard = guarded(controller)
    place = np.array([[0.7, 0.0, 1.0], [1.0, 0.0, 1.5]])

    def moved(t: float, age: float) -> float:
        """Return by how much cf1 is moved in x [m]; cf2, above it, was measured `age` ago."""
        state = replace(state_at(t, (0.0, age)), pos=place)
        command = guard.update(state, replace(setpoint_at(t), pos=place), None)
        assert command.names == NAMES[: len(statuses)]
        assert command.status[0] == OK
        return float(controller.given[-1].pos[0, 0]) - 0.7

    assert [moved(k * TICK, 0.0) for k in range(5)] == [0.0] * 5
    assert [moved(k * TICK, k * TICK - 0.04) for k in range(5, 39)] == [0.0] * 34  # it coasts
    assert [moved(k * TICK, k * TICK - 0.04) for k in range(41, 43)][-1] < 0.0
    assert [moved(k * TICK, k * TICK - 0.04) for k in range(43, 200)][-1] < -0.25
    after_cut = PARAMS.cut_after_s + 0.1
    assert abs([moved(k * TICK, after_cut) for k in range(200, 750)][-1]) < 0.01


@pytest.mark.parametrize("gap", [0.05, 0.5, 2.0])
def test_vehicles_that_flew_level_without_ticks_climb_where_they_are_measured_again(gap: float) -> None:
    controller = Scripted(OK, OK)
    guard = guarded(controller)
    for k in range(5):
        guard.update(state_at(k * TICK), setpoint_at(k * TICK), None)
    assert guard.without_tick(gap) is not None
    before = state_at(0.0).pos
    sunk, plan = before - [0.2, 0.1, 0.4], before + np.array([0.6, 0.0, 0.0])
    for k in range(12):  # those after a gap of 2 s are not accepted for 0.1 s
        t = 0.05 + gap + k * TICK
        guard.update(replace(state_at(t), pos=sunk), replace(setpoint_at(t), pos=plan), None)
    climbing = np.column_stack((sunk[:, :2], plan[:, 2]))
    np.testing.assert_array_equal(controller.given[-1].pos, climbing if gap > PARAMS.level_after_s else plan)


def test_a_vehicle_that_was_fast_in_calm_flight_brakes_once_nobody_sees_it() -> None:
    controller = Scripted(OK, OK)
    guard = guarded(controller)
    for k in range(5):
        state = state_at(k * TICK)
        state.vel[0] = [1.0, 0.0, 0.0]
        guard.update(state, setpoint_at(k * TICK), None)
    controller.status = (LEVEL, OK)
    output = guard.update(state_at(0.05, (TICK, 0.0)), setpoint_at(0.05), None)
    assert output.status.tolist() == [LEVEL, OK]
    braking = min(1.0 / BRAKING_S, BRAKING_MAX)
    assert output.pitch.tolist() == [pytest.approx(-np.arctan(braking / GRAVITY)), 0.0]  # nose up, against +x


@pytest.mark.parametrize("seen", [(0.0, 0.0), (0.0, 0.3)], ids=["all measured", "another one lost"])
@pytest.mark.parametrize("predicted", [0.0, -1.0])
def test_the_lift_that_a_vehicle_hovered_with_is_what_it_begins_to_fly_level_with(
    seen: tuple[float, float], predicted: float
) -> None:
    """It is measured at rest under a command of more than its weight."""

    class Lifting(Scripted):
        share = 1.1

        def update(self, *given: object) -> SwarmCommand:
            made = super().update(*given)
            return replace(made, thrust=self.share * made.thrust)

    controller = Lifting(OK, OK)
    guard = guarded(controller)
    downwash = Interference(
        0.0, NAMES, np.tile([0.0, 0.0, predicted], (2, 1)), np.zeros((2, 3)), np.zeros(2, np.uint8)
    )
    for k in range(300):
        guard.update(state_at(k * TICK, seen), setpoint_at(k * TICK), downwash)
    controller.status, controller.share = (LEVEL, OK), 1.0
    output = guard.update(state_at(3.0, (TICK, seen[1])), setpoint_at(3.0), downwash)
    assert output.thrust[0] == pytest.approx(1.1 * HOVER, rel=1e-3)


def test_a_pose_that_is_no_number_of_one_above_counts_as_none_below_it() -> None:
    """cf1 is lost under the predicted downwash of cf2, which another controls; one pose of that is NaN."""
    downwash = Interference(
        0.0, NAMES, np.array([[0.0, 0.0, -1.0], [0.0] * 3]), np.zeros((2, 3)), np.zeros(2, np.uint8)
    )

    def lift(x: float, status: TrackStatus) -> list[float]:
        """Return the thrusts of cf1 [N] around a tick with such an x [m] and status of cf2."""
        controller = Scripted(OK)
        guard, made = guarded(controller), []
        for k in range(60):
            odd, age = k == 30, max(k - 10, 0) * TICK
            controller.status = (LEVEL if k > 10 else OK,)
            state = state_at(k * TICK, (age, 0.0), coast=0.0)
            state.pos[1] = [x if odd else 0.1, 0.0, 1.5]
            state.status[1] = status if odd else TrackStatus.TRACKED
            made.append(float(guard.update(state, setpoint_at(k * TICK), downwash).thrust[0]))
        return made[25:]

    assert lift(np.nan, TrackStatus.TRACKED) == lift(0.1, TrackStatus.LOST)
    assert np.isfinite(lift(np.nan, TrackStatus.TRACKED)).all()
