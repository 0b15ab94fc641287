"""The guard of a controller: by age through the fallback phases and back, and an emergency."""

import numpy as np
import pytest
from guarded_flights import (
    CUT,
    DEGRADED,
    HOLD,
    HOVER,
    LAND,
    LEVEL,
    NAMES,
    OK,
    PARAMS,
    SATURATED,
    TICK,
    Scripted,
    fly,
    guarded,
    mpc,
    pid,
    setpoint_at,
    state_at,
)
from resting_signals import resting_state

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.tracking_loss.braking_law import BRAKING_MAX, BRAKING_S
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import (
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
    index_of,
)
from q2q_model.vehicle.constants import GRAVITY


def test_a_guard_lets_every_command_of_fresh_states_through_untouched() -> None:
    guard, bare = guarded(), pid()
    for k in range(20):
        t = k * TICK
        output, given = (
            guard.update(state_at(t), setpoint_at(t), None),
            bare.update(state_at(t), setpoint_at(t), None),
        )
        for name in ("thrust", "roll", "pitch", "yaw_rate", "status"):
            np.testing.assert_array_equal(getattr(output, name), getattr(given, name))


@pytest.mark.parametrize("late", [0.0, TICK])
@pytest.mark.parametrize("status", [OK, SATURATED])
def test_of_a_tick_in_which_all_is_known_of_everybody_the_answer_is_the_controllers_own(
    status: int, late: float
) -> None:
    controller = Scripted(status, OK)
    guard = Guard(controller, PARAMS, HOVER, lateness=lambda _: late)
    for k in range(3):
        output = guard.update(state_at(k * TICK), setpoint_at(k * TICK), None)
    assert output is controller.made


def test_a_controller_of_some_vehicles_is_passed_through_while_those_are_measured() -> None:
    controller = Scripted(OK)
    guard = guarded(controller)
    for k in range(3):
        output = guard.update(state_at(k * TICK, (0.0, 0.2)), setpoint_at(k * TICK), None)
    assert output is controller.made
    assert guard.without_tick(0.02) is None
    late = guard.update(state_at(1.0, (0.2, 0.0)), setpoint_at(1.0), None)
    assert late.status.tolist() == [DEGRADED]


@pytest.mark.parametrize("make", [pid, mpc], ids=["pid", "mpc"])
def test_an_unseen_vehicle_goes_through_the_phases_by_age_and_its_neighbour_flies_on(make: type) -> None:
    commands = fly(guarded(make()), 0, 620, unseen_since=0.1)
    statuses = np.array([command.status for command in commands])
    assert (statuses[:, 1] <= SATURATED).all()
    since = {
        status: float(np.flatnonzero(statuses[:, 0] == status)[0]) * TICK - 0.1
        for status in (DEGRADED, HOLD, LEVEL, LAND, CUT)
    }
    # ages as documented; within a tick, since ages are differences of floats
    # hold_duration is 0.1 s after 0.35 s
    assert since[DEGRADED] == pytest.approx(0.05, abs=0.0101)
    assert since[HOLD] == pytest.approx(0.36, abs=0.0101)
    assert since[LEVEL] == pytest.approx(0.46, abs=0.0101)
    assert since[LAND] == pytest.approx(1.0, abs=0.0101)
    assert since[CUT] == pytest.approx(5.0, abs=0.0101)
    assert since[DEGRADED] <= 0.06  # the safe action within 60 ms of the fault
    landing = commands[200]
    assert landing.thrust[0] == pytest.approx(0.94 * HOVER, rel=1e-4)  # what it hovered with is forgotten
    assert commands[-1].thrust[0] == 0.0
    order = [
        status for status, before in zip(statuses[1:, 0], statuses[:-1, 0], strict=True) if status != before
    ]
    assert [int(one) for one in order if one not in (OK, SATURATED)] == [DEGRADED, HOLD, LEVEL, LAND, CUT]


def test_a_vehicle_that_is_seen_again_before_the_cut_flies_on_and_a_cut_one_does_not() -> None:
    guard = guarded()
    fly(guard, 0, 450, unseen_since=0.1)
    back = fly(guard, 450, 452)[-1]
    assert back.status[0] <= SATURATED
    assert back.pitch[0] > 0.0  # towards its setpoint
    guard = guarded()
    fly(guard, 0, 520, unseen_since=0.1)
    assert fly(guard, 520, 522)[-1].status[0] == CUT


def test_a_vehicle_never_seen_counts_from_the_first_tick() -> None:
    guard = guarded()
    commands = [
        guard.update(state_at(k * TICK, (np.inf, 0.0)), setpoint_at(k * TICK), None) for k in range(510)
    ]
    assert commands[0].status[0] == LEVEL
    assert commands[99].status[0] == LEVEL
    assert commands[101].status[0] == LAND
    assert commands[501].status[0] == CUT


def test_the_age_counts_however_trusting_the_filter_is() -> None:
    guard = guarded()
    statuses = []
    for k in range(120):
        t = k * TICK
        statuses.append(int(guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None).status[0]))
    assert statuses[4] <= SATURATED
    assert statuses[6] == DEGRADED
    assert statuses[98] == DEGRADED
    assert statuses[101] == LAND


@pytest.mark.parametrize("age", [np.nan, -1.0, np.inf])
def test_an_age_that_is_none_is_not_trusted(age: float) -> None:
    guard = guarded()
    fly(guard, 0, 5)
    statuses = [
        int(guard.update(state_at(k * TICK, (age, 0.0), coast=np.inf), setpoint_at(k * TICK), None).status[0])
        for k in range(5, 120)
    ]
    assert statuses[-1] == LAND


def test_a_cut_vehicle_that_is_not_commanded_for_a_while_stays_cut() -> None:
    guard = guarded()
    assert fly(guard, 0, 520, unseen_since=0.0)[-1].status.tolist() == [CUT, OK]
    for k, names in enumerate((NAMES[1:], (), NAMES[1:])):
        t = (520 + k) * TICK
        setpoint = setpoint_at(t)
        some = of_vehicles(setpoint, index_of(names, NAMES))
        assert guard.update(state_at(t), some, None).status.tolist() == [OK] * len(names)
    assert fly(guard, 523, 525)[-1].status.tolist() == [CUT, OK]


def test_an_orientation_that_is_no_number_leaves_no_trace_in_dead_reckoning() -> None:
    guard, sane = guarded(), guarded()
    for one in (guard, sane):
        fly(one, 0, 50)
        bad = state_at(0.5)
        if one is guard:
            bad.quat[0] = np.nan
        one.update(bad, setpoint_at(0.5), None)
    for answers in zip(
        fly(guard, 51, 120, unseen_since=0.6), fly(sane, 51, 120, unseen_since=0.6), strict=True
    ):
        for values in ("thrust", "roll", "pitch"):
            found, expected = (getattr(one, values) for one in answers)
            np.testing.assert_allclose(found, expected, atol=0.02)


def test_an_emergency_cuts_all_at_once_and_stays_through_a_reset() -> None:
    guard = guarded()
    fly(guard, 0, 5)
    assert not guard.emergency
    at_once = guard.cut_all()
    assert at_once is not None
    assert guard.emergency
    late = guard.update(state_at(0.03), setpoint_at(0.03), None)
    for command in (at_once, late, fly(guard, 5, 6)[0]):
        assert command.thrust.tolist() == [0.0, 0.0]
        assert command.status.tolist() == [CUT, CUT]
    guard.reset()
    assert fly(guard, 0, 1)[0].status.tolist() == [CUT, CUT]


def test_an_emergency_before_the_first_tick_cuts_that() -> None:
    guard = guarded()
    assert guard.cut_all() is None
    assert fly(guard, 0, 1)[0].status.tolist() == [CUT, CUT]


def test_a_controller_that_gives_no_numbers_is_answered_with_level_hover() -> None:
    class Broken:
        def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
            return SwarmCommand(
                setpoint.t,
                NAMES,
                np.array([np.nan, 0.3]),
                np.array([0.1, 0.1]),
                np.array([0.2, 0.2]),
                np.array([0.3, 0.3]),
                np.zeros(2, dtype=np.uint8),
            )

        def reset(self) -> None:
            pass

    guard = guarded(Broken())
    for t in (0.0, 0.01):  # before the vehicles are known, and after
        output = guard.update(state_at(t), setpoint_at(t), None)
        assert output.thrust.tolist() == [HOVER, 0.3]
        assert output.roll.tolist() == [0.0, 0.1]
        assert output.pitch.tolist() == [0.0, 0.2]
        assert output.yaw_rate.tolist() == [0.0, 0.3]
        assert output.status.tolist() == [LEVEL, OK]


class Saturated:
    """A controller at its limits."""

    def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
        """Answer SATURATED."""
        some = np.full(2, 0.1)
        return SwarmCommand(setpoint.t, NAMES, some, some, some, some, np.full(2, SATURATED, dtype=np.uint8))

    def reset(self) -> None:
        """Do nothing."""


def test_a_saturated_vehicle_is_a_sound_one_beside_one_that_lands() -> None:
    guard = guarded(Saturated())
    for k in range(120):
        t = k * TICK
        output = guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    assert output.status.tolist() == [LAND, SATURATED]
    again = guard.update(state_at(1.0), setpoint_at(1.0), None)
    assert again.status.tolist() == [LAND, HOLD]


def test_phases_begin_at_their_ages_not_after() -> None:
    guard = guarded()
    guard.update(state_at(0.0), setpoint_at(0.0), None)
    at = {
        t: guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None).status[0]
        for t in (0.05, 1.0, 2.0, 3.0, 4.0, 5.0)
    }
    assert at == {0.05: DEGRADED, 1.0: LAND, 2.0: LAND, 3.0: LAND, 4.0: LAND, 5.0: CUT}


def test_what_is_known_follows_vehicles_by_name() -> None:
    guard = guarded()
    fly(guard, 0, 200, unseen_since=0.1)  # cf1 lands
    alone = guard.update(state_at(2.0, (1.9, 0.0)), setpoint_at(2.0, ("cf1",)), None)
    assert alone.names == ("cf1",)
    assert alone.status.tolist() == [LAND]


@pytest.mark.parametrize("make", [pid, mpc], ids=["pid", "mpc"])
def test_signals_of_nobody_leave_every_vehicle_without_a_state(make: type) -> None:
    nobody = resting_state(0.0, (), np.zeros((0, 3)), quat=np.zeros((0, 4)))
    output = guarded(make()).update(nobody, setpoint_at(0.0), None)
    assert output.names == NAMES
    assert output.status.tolist() == [LEVEL, LEVEL]


@pytest.mark.parametrize("others_age", [0.0, 0.3])
def test_a_sample_that_the_filter_does_not_trust_yet_is_no_measurement(others_age: float) -> None:
    """An outlier just before a vehicle is lost: it brakes from the speed before, not from the outlier's."""
    controller = Scripted(OK, OK)
    guard = guarded(controller)
    for k in range(7):
        state = state_at(k * TICK, (max(k - 5, 0) * TICK, others_age))
        state.vel[0] = [-1.0 if k >= 5 else 1.0, 0.0, 0.0]
        if k == 5:
            state.status[0] = TrackStatus.COASTING
        guard.update(state, setpoint_at(k * TICK), None)
    controller.status = (LEVEL, OK)
    output = guard.update(state_at(7 * TICK, (2 * TICK, others_age)), setpoint_at(7 * TICK), None)
    braking = min(1.0 / BRAKING_S, BRAKING_MAX)
    assert output.pitch[0] == pytest.approx(-np.arctan(braking / GRAVITY))  # nose up, against +x
