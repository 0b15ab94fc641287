"""The guard of a controller: by age down the failsafe ladder and up again, and an emergency."""

from dataclasses import replace

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
    Level,
    Scripted,
    fly,
    guarded,
    mpc,
    pid,
    setpoint_at,
    state_at,
)

from q2q_control.failsafe.blind_flight.braking_law import BRAKING_MAX, BRAKING_S
from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.tick_watch import TickWatch
from q2q_model.signals.values import (
    Interference,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
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


def test_who_is_beneath_an_unseen_vehicle_makes_way_and_a_clock_set_back_moves_it_no_further() -> None:
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
def test_a_vehicle_makes_way_for_a_lost_one_as_soon_as_it_is_lost_until_that_is_cut(
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
    after_cut = PARAMS.cut_s + 0.1
    assert abs([moved(k * TICK, after_cut) for k in range(200, 750)][-1]) < 0.01


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
def test_an_unseen_vehicle_goes_down_the_ladder_by_age_and_its_neighbour_flies_on(make: type) -> None:
    commands = fly(guarded(make()), 0, 620, unseen_since=0.1)
    statuses = np.array([command.status for command in commands])
    assert (statuses[:, 1] <= SATURATED).all()
    since = {
        status: float(np.flatnonzero(statuses[:, 0] == status)[0]) * TICK - 0.1
        for status in (DEGRADED, HOLD, LEVEL, LAND, CUT)
    }
    # ages as documented; within a tick, since ages are differences of floats. hold_time is 0.1 s after 0.35 s
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


def test_an_emergency_cuts_all_at_once_and_stays_through_a_reset() -> None:
    guard = guarded()
    fly(guard, 0, 5)
    guard.cut()
    at_once = guard.without_tick(0.0)
    assert at_once is not None
    for command in (at_once, fly(guard, 5, 6)[0]):
        assert command.thrust.tolist() == [0.0, 0.0]
        assert command.status.tolist() == [CUT, CUT]
    guard.reset()
    assert fly(guard, 0, 1)[0].status.tolist() == [CUT, CUT]


def test_an_older_tick_gets_the_last_answer() -> None:
    guard = guarded()
    last = fly(guard, 0, 300)[-1]
    for t in (2.95, 2.5, 2.0):  # out of order: still the same clock
        again = guard.update(state_at(t), setpoint_at(t), None)
        assert again.t == t
        assert again.pitch.tolist() == last.pitch.tolist()
        assert again.status.tolist() == [HOLD, HOLD]


@pytest.mark.parametrize("back", [0.2, 1.0])
def test_a_clock_set_back_lets_ages_go_on_and_leaves_who_is_cut_on_the_floor(back: float) -> None:
    guard = guarded()
    for k in range(520):
        t = k * TICK
        output = guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    assert output.status.tolist() == [CUT, OK]
    begin = t - back
    for k in range(11):
        now = begin + k * TICK
        output = guard.update(state_at(now, (t, 0.0), coast=10.0), setpoint_at(now), None)
        assert output.t == now
        assert output.status.tolist() == [CUT, HOLD if k < 10 else OK]


def test_a_clock_set_back_does_not_make_young_who_was_not_seen() -> None:
    guard = guarded()
    for k in range(96):
        t = k * TICK
        guard.update(state_at(t, (t, 0.0), coast=0.35), setpoint_at(t), None)
    begin = 0.3  # unseen for 0.95 s, by whatever clock
    statuses = []
    for k in range(18):
        t = begin + k * TICK
        output = guard.update(state_at(t, (np.inf, 0.0), coast=0.35), setpoint_at(t), None)
        statuses.append(output.status[0])
    assert LAND not in statuses[:10]
    assert statuses[10:] == [LAND] * 8  # 1.05 s and more: the 0.1 s before the new time is believed count


def test_a_flight_that_begins_again_is_another_one() -> None:
    guard = guarded()
    for k in range(520):
        t = k * TICK
        guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    anew = guard.update(state_at(4.1), setpoint_at(4.1), None)
    assert (anew.t, anew.status.tolist()) == (4.1, [OK, OK])


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


def test_a_repeated_tick_is_no_older_one() -> None:
    guard = guarded()
    first = fly(guard, 0, 5)[-1]
    again = guard.update(state_at(0.04), setpoint_at(0.04), None)
    assert again.status.tolist() == [OK, OK]
    np.testing.assert_array_equal(again.pitch, first.pitch)


def test_a_tick_older_by_just_what_a_restart_takes_is_of_the_same_flight() -> None:
    guard = guarded()
    guard.update(state_at(2.0), setpoint_at(2.0), None)
    assert guard.update(state_at(1.0), setpoint_at(1.0), None).status.tolist() == [HOLD, HOLD]
    assert guard.newest == 2.0


def test_phases_begin_at_their_ages_not_after() -> None:
    guard = guarded()
    guard.update(state_at(0.0), setpoint_at(0.0), None)
    at = {
        t: guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None).status[0]
        for t in (0.05, 1.0, 5.0)
    }
    assert at == {0.05: DEGRADED, 1.0: LAND, 5.0: CUT}


def test_lateness_and_the_filters_age_add_up_with_and_without_ticks() -> None:
    guard = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.03)
    for k in range(10):
        output = guard.update(state_at(k * TICK, (0.03, 0.0)), setpoint_at(k * TICK), None)
    assert output.status.tolist() == [DEGRADED, OK]
    old = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.01)
    for k in range(10):
        output = old.update(state_at(k * TICK, (0.045, 0.0)), setpoint_at(k * TICK), None)
    assert output.status.tolist() == [DEGRADED, OK]
    calm = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.02)
    for k in range(10):
        calm.update(state_at(k * TICK), setpoint_at(k * TICK), None)
    quiet = calm.without_tick(4.97)
    late = calm.without_tick(4.99)
    assert quiet is not None
    assert late is not None
    assert (quiet.status[0], late.status[0]) == (LAND, CUT)


def test_what_is_known_follows_vehicles_by_name() -> None:
    guard = guarded()
    fly(guard, 0, 200, unseen_since=0.1)  # cf1 lands
    alone = guard.update(state_at(2.0, (1.9, 0.0)), setpoint_at(2.0, ("cf1",)), None)
    assert alone.names == ("cf1",)
    assert alone.status.tolist() == [LAND]


def test_without_ticks_all_are_held_then_level_then_land_then_cut() -> None:
    guard = guarded()
    last = fly(guard, 0, 10)[-1]
    assert guard.without_tick(0.029) is None
    found = {age: guard.without_tick(age) for age in (0.03, 0.10, 1.0, 4.99, 5.0)}
    statuses = {age: command.status.tolist() for age, command in found.items() if command is not None}
    assert statuses == {
        0.03: [HOLD] * 2,
        0.10: [LEVEL] * 2,
        1.0: [LAND] * 2,
        4.99: [LAND] * 2,
        5.0: [CUT] * 2,
    }
    held = found[0.03]
    assert held is not None
    np.testing.assert_array_equal(held.pitch, last.pitch)
    assert held.t == pytest.approx(last.t + 0.03)
    # cut stays, though ticks come again
    assert fly(guard, 600, 601)[0].status.tolist() == [CUT] * 2


def test_without_ticks_a_swarm_that_flew_brakes_to_rest_and_one_that_hovered_stays_level() -> None:
    """Its body's z axis follows the command at once; the reckoning allows for a lag only before it begins."""
    for speed in (0.0, 1.0):
        guard = Guard(Level(), PARAMS, HOVER)
        for k in range(20):
            moving = replace(state_at(k * TICK), vel=np.tile([speed, 0.0, 0.0], (2, 1)))
            guard.update(moving, setpoint_at(k * TICK), None)
        vel, most = speed, 0.0
        for k in range(1, 300):
            output = guard.without_tick(max(k * TICK, PARAMS.hold_s))
            assert output is not None
            vel += TICK * GRAVITY * np.tan(output.pitch[0])
            most = max(most, abs(float(output.pitch[0])))
        assert abs(vel) < 0.02 * speed + 1e-12
        assert most == pytest.approx(np.arctan(min(speed / BRAKING_S, BRAKING_MAX) / GRAVITY))


def test_nothing_is_sent_before_the_first_tick_ever() -> None:
    assert guarded().without_tick(10.0) is None
    assert TickWatch(guarded(), PARAMS).due(state_at(0.0), 10.0) is None


@pytest.mark.parametrize("make", [pid, mpc], ids=["pid", "mpc"])
def test_signals_of_nobody_leave_every_vehicle_without_a_state(make: type) -> None:
    nobody = SwarmState(
        0.0, (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0),
        np.zeros(0, dtype=np.uint8),
    )  # fmt: skip
    output = guarded(make()).update(nobody, setpoint_at(0.0), None)
    assert output.names == NAMES
    assert output.status.tolist() == [LEVEL, LEVEL]


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
