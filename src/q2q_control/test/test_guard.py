"""The state machine of a vehicle's controller: by ages, down the ladder and up again, and an emergency."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from q2q_control.failsafe.dead_reckoned_braking import BRAKING_MAX, BRAKING_S
from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.failsafe.stamp_delay import MOST_S, WINDOW_S, StampDelayMonitor
from q2q_control.failsafe.tick_watch import TickWatch
from q2q_control.inputs.controller import Controller
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.receding import Mpc
from q2q_control.pid.pid import Pid, PidParams
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.signals.values import (
    CommandStatus,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

HOVER = CRAZYFLIE_2_0.hover_thrust
TICK = 0.01
NAMES = ("cf1", "cf2")
PARAMS = FallbackParams()
OK, SATURATED, HOLD, LEVEL, DEGRADED, LAND, CUT = (int(CommandStatus[name]) for name in (
    "OK", "SATURATED", "HOLD", "LEVEL", "DEGRADED", "LAND", "CUT"
))  # fmt: skip


def state_at(t: float, ages: tuple[float, ...] = (0.0, 0.0), coast: float = 0.35) -> SwarmState:
    """Return two hovering vehicles, measured `ages` ago; lost beyond `coast`, as the filter has it."""
    age = np.array(ages)
    late = np.where(age <= coast, TrackStatus.COASTING, TrackStatus.LOST)
    return SwarmState(
        t=t,
        names=NAMES,
        pos=np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.5]]),
        vel=np.zeros((2, 3)),
        quat=np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)),
        ang_vel_body=np.zeros((2, 3)),
        age=age,
        status=np.where(age == 0.0, TrackStatus.TRACKED, late).astype(np.uint8),
    )


def setpoint_at(t: float, names: Names = NAMES, x: float = 0.1) -> SwarmSetpoint:
    count = len(names)
    pos = np.array([[x, 0.0, 1.0], [1.0, 0.0, 1.5]])[:count]
    zero = np.zeros((count, 3))
    return SwarmSetpoint(
        t, names, pos, zero, zero, np.zeros(count), np.zeros(count), np.zeros(count, dtype=np.uint8)
    )


def pid() -> Pid:
    return Pid(PidParams(), CRAZYFLIE_2_0)


def mpc() -> Mpc:
    return Mpc(MpcParams(), CRAZYFLIE_2_0, NoInteraction())


class Level:
    """Hover, whatever comes."""

    def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
        """Return level hover."""
        zero = np.zeros(2)
        status = np.full(2, OK, dtype=np.uint8)
        return SwarmCommand(setpoint.t, NAMES, np.full(2, HOVER), zero, zero, zero, status)

    def reset(self) -> None:
        """Remember nothing."""


class Told:
    """A controller that gives what it is told to, and keeps the setpoints it was given."""

    def __init__(self, *status: int) -> None:
        self.status, self.given = status, list[SwarmSetpoint]()

    def update(self, _: SwarmState, setpoint: SwarmSetpoint, __: object) -> SwarmCommand:
        """Return level hover under these statuses."""
        self.given.append(setpoint)
        self.made = replace(Level().update(_, setpoint, __), status=np.array(self.status, dtype=np.uint8))
        return self.made

    def reset(self) -> None:
        """Keep what was given."""


def guarded(controller: Controller | None = None) -> Guard:
    return Guard(controller or pid(), PARAMS, HOVER)


def fly(guard: Guard, first: int, last: int, unseen_since: float | None = None) -> list[SwarmCommand]:
    """Answer ticks first to last, not seeing cf1 since a time [s]."""
    made = []
    for k in range(first, last):
        t = k * TICK
        age = 0.0 if unseen_since is None or t <= unseen_since else t - unseen_since
        made.append(guard.update(state_at(t, (age, 0.0)), setpoint_at(t), None))
    return made


def test_a_guard_lets_every_command_of_fresh_states_through_untouched() -> None:
    guard, bare = guarded(), pid()
    for k in range(20):
        t = k * TICK
        told, given = (
            guard.update(state_at(t), setpoint_at(t), None),
            bare.update(state_at(t), setpoint_at(t), None),
        )
        for name in ("thrust", "roll", "pitch", "yaw_rate", "status"):
            np.testing.assert_array_equal(getattr(told, name), getattr(given, name))


@pytest.mark.parametrize("late", [0.0, TICK])
@pytest.mark.parametrize("status", [OK, SATURATED])
def test_of_a_tick_in_which_all_is_known_of_everybody_the_answer_is_the_controllers_own(
    status: int, late: float
) -> None:
    controller = Told(status, OK)
    guard = Guard(controller, PARAMS, HOVER, lateness=lambda _: late)
    for k in range(3):
        told = guard.update(state_at(k * TICK), setpoint_at(k * TICK), None)
    assert told is controller.made


def test_who_is_beneath_an_unseen_vehicle_makes_way_and_a_clock_set_back_moves_it_no_further() -> None:
    controller = Told(OK, OK)
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
    assert landing.thrust[0] == pytest.approx(0.94 * HOVER)
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
        told = guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    assert told.status.tolist() == [CUT, OK]
    begin = t - back
    for k in range(11):
        told = guard.update(state_at(begin, (t, 0.0), coast=10.0), setpoint_at(begin + k * TICK), None)
        assert told.t == begin + k * TICK
        assert told.status.tolist() == [CUT, HOLD if k < 10 else OK]


def test_a_clock_set_back_does_not_make_young_who_was_not_seen() -> None:
    guard = guarded()
    for k in range(96):
        t = k * TICK
        guard.update(state_at(t, (t, 0.0), coast=0.35), setpoint_at(t), None)
    begin = 0.3  # unseen for 0.95 s, by whatever clock
    statuses = []
    for k in range(18):
        t = begin + k * TICK
        told = guard.update(state_at(t, (np.inf, 0.0), coast=0.35), setpoint_at(t), None)
        statuses.append(told.status[0])
    assert LAND not in statuses[:15]
    assert statuses[15:] == [LAND] * 3  # 1.0 s, but for the 0.1 s in which no time passed


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
        told = guard.update(state_at(t), setpoint_at(t), None)
        assert told.thrust.tolist() == [HOVER, 0.3]
        assert told.roll.tolist() == [0.0, 0.1]
        assert told.pitch.tolist() == [0.0, 0.2]
        assert told.yaw_rate.tolist() == [0.0, 0.3]
        assert told.status.tolist() == [LEVEL, OK]


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
        told = guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    assert told.status.tolist() == [LAND, SATURATED]
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
        told = guard.update(state_at(k * TICK, (0.03, 0.0)), setpoint_at(k * TICK), None)
    assert told.status.tolist() == [DEGRADED, OK]
    old = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.01)
    for k in range(10):
        told = old.update(state_at(k * TICK, (0.045, 0.0)), setpoint_at(k * TICK), None)
    assert told.status.tolist() == [DEGRADED, OK]
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
            told = guard.without_tick(max(k * TICK, PARAMS.hold_s))
            assert told is not None
            vel += TICK * GRAVITY * np.tan(told.pitch[0])
            most = max(most, abs(float(told.pitch[0])))
        assert abs(vel) < 0.02 * speed + 1e-12
        assert most == pytest.approx(np.arctan(min(speed / BRAKING_S, BRAKING_MAX) / GRAVITY))


def test_nothing_is_sent_before_the_first_tick_ever() -> None:
    assert guarded().without_tick(10.0) is None
    assert TickWatch(guarded(), PARAMS).due(state_at(0.0), 10.0) is None


def watched(ticks: int) -> tuple[Guard, TickWatch]:
    guard = guarded()
    watch = TickWatch(guard, PARAMS)
    for k in range(ticks):
        guard.update(state_at(k * TICK), setpoint_at(k * TICK), None)
        watch.answered(setpoint_at(k * TICK), now=100.0 + k * TICK)
    return guard, watch


def test_a_reference_that_stays_away_leaves_a_vehicle_hovering_where_it_was_sent() -> None:
    _, watch = watched(10)
    assert watch.due(state_at(0.12), now=100.0 + 0.115) is None  # 25 ms late: merely late
    command = watch.due(state_at(0.12), now=100.0 + 0.125)
    assert command is not None
    assert command.t == 0.12
    assert command.status.tolist() == [DEGRADED] * 2
    assert command.pitch[0] == pytest.approx(
        4.0 * 0.1 / 9.81, rel=0.02
    )  # k_p_xy x error over g: still tracking
    again = watch.due(state_at(0.13), now=100.0 + 0.135)
    assert again is not None
    assert again.t == 0.13  # the next state is taken at once


def test_a_hover_in_place_of_a_reference_is_degraded_even_at_the_limits() -> None:
    guard = guarded()
    watch = TickWatch(guard, PARAMS)
    for t in (0.0, 0.01):
        guard.update(state_at(t), setpoint_at(t, x=50.0), None)
    watch.answered(setpoint_at(0.01, x=50.0), now=0.0)
    command = watch.due(state_at(0.02), now=0.03)  # just then
    assert command is not None
    assert command.status.tolist() == [DEGRADED] * 2
    assert guard.update(state_at(0.02), setpoint_at(0.02, x=50.0), None).status[0] == SATURATED


def test_a_word_that_nothing_will_come_is_the_next_look_and_no_more() -> None:
    _, watch = watched(10)
    assert watch.due(state_at(0.09), now=100.0 + 0.109, ahead=0.01) is None
    early = watch.due(state_at(0.09), now=100.0 + 0.111, ahead=0.01)
    assert early is not None
    assert early.status.tolist() == [HOLD] * 2
    assert early.t == pytest.approx(0.09 + PARAMS.hold_s)  # so that the next look's is never older
    later = watch.due(state_at(0.09), now=100.0 + 0.16, ahead=0.01)
    assert later is not None
    assert later.t == pytest.approx(0.16)


def test_a_real_tick_ends_the_hovering() -> None:
    guard, watch = watched(10)
    watch.due(state_at(0.12), now=100.125)
    guard.update(state_at(0.13), setpoint_at(0.13), None)
    watch.answered(setpoint_at(0.13), now=100.131)
    assert watch.due(state_at(0.14), now=100.141) is None


def test_frames_that_repeat_are_no_news() -> None:
    _, watch = watched(10)
    statuses = []
    for k in range(10, 130):  # the last tick is answered again and again
        now = 100.0 + k * TICK
        watch.answered(setpoint_at(0.09), now)
        command = watch.due(state_at(0.09), now)
        statuses.append(None if command is None else int(command.status[0]))
    assert statuses[0] is None
    assert statuses[4] == HOLD
    assert statuses[50] == LEVEL
    assert statuses[-1] == LAND


def test_an_old_tick_is_no_news_and_that_of_a_clock_set_back_is() -> None:
    guard, watch = watched(10)
    guard.update(state_at(0.07), setpoint_at(0.07), None)
    watch.answered(setpoint_at(0.07), now=100.10)
    held = watch.due(state_at(0.07), now=100.09 + PARAMS.hold_s + 0.001)
    assert held is not None
    assert held.status.tolist() == [HOLD] * 2
    now = 100.2
    for k in range(20):  # longer than old stamps must rise to be the new time
        guard.update(state_at(-0.5 + k * TICK), setpoint_at(-0.5 + k * TICK), None)
        watch.answered(setpoint_at(-0.5 + k * TICK), now=now + k * TICK)
    assert guard.newest == pytest.approx(-0.31)
    assert watch.due(state_at(-0.31), now=now + 0.20) is None


def test_the_largest_lateness_that_is_told_lands_nobody() -> None:
    assert PARAMS.land_s > MOST_S


def test_a_stream_that_is_suddenly_late_shows_by_how_much() -> None:
    clock = StampDelayMonitor()
    for k in range(100):
        assert clock.lateness(k * TICK, 5000.0 + k * TICK + 0.02) == pytest.approx(0.0, abs=1e-9)
    assert clock.lateness(1.0, 5001.0 + 0.02 + 0.2) == pytest.approx(0.2, abs=1e-9)
    assert clock.lateness(1.01, 5001.01 + 0.02 + 3.0) == MOST_S


def test_what_was_usual_is_forgotten_after_two_windows() -> None:
    clock = StampDelayMonitor()
    clock.lateness(0.0, 100.0)
    late = [clock.lateness(k * TICK, 100.0 + k * TICK + 0.1) for k in range(1, 450)]
    assert late[0] == pytest.approx(0.1, abs=1e-9)
    assert late[300] == pytest.approx(0.1, abs=1e-9)  # windows are of 2 s
    assert late[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_window_ends_after_its_length_not_with_it() -> None:
    clock = StampDelayMonitor()
    clock.lateness(0.0, 0.0)
    late = [clock.lateness(now - 0.1, now) for now in (WINDOW_S, 2.5, 4.2)]
    assert late == pytest.approx([0.1, 0.1, 0.1], abs=1e-9)


def test_a_clock_that_runs_slower_lands_nobody_by_itself() -> None:
    assert PARAMS.land_s > MOST_S


def test_lateness_adds_to_the_age() -> None:
    said: NDArray[np.float64] = np.zeros(1)
    guard = Guard(pid(), PARAMS, HOVER, lateness=lambda _: float(said[0]))
    assert guard.update(state_at(0.0), setpoint_at(0.0), None).status.tolist() == [OK, OK]
    said[0] = 0.06
    assert guard.update(state_at(0.01), setpoint_at(0.01), None).status.tolist() == [
        OK,
        OK,
    ]  # known since 0.0
    told = [guard.update(state_at(k * TICK), setpoint_at(k * TICK), None).status[0] for k in range(2, 12)]
    assert DEGRADED in told


@pytest.mark.parametrize("make", [pid, mpc], ids=["pid", "mpc"])
def test_signals_of_nobody_leave_every_vehicle_without_a_state(make: type) -> None:
    nobody = SwarmState(
        0.0, (), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0),
        np.zeros(0, dtype=np.uint8),
    )  # fmt: skip
    told = guarded(make()).update(nobody, setpoint_at(0.0), None)
    assert told.names == NAMES
    assert told.status.tolist() == [LEVEL, LEVEL]


def test_a_vehicle_that_was_fast_in_calm_flight_brakes_once_nobody_sees_it() -> None:
    controller = Told(OK, OK)
    guard = guarded(controller)
    for k in range(5):
        state = state_at(k * TICK)
        state.vel[0] = [min(k, 1), 0.0, 0.0]  # at rest in the first tick, which is not yet a calm one
        guard.update(state, setpoint_at(k * TICK), None)
    controller.status = (LEVEL, OK)
    told = guard.update(state_at(0.05, (TICK, 0.0)), setpoint_at(0.05), None)
    assert told.status.tolist() == [LEVEL, OK]
    braking = min(1.0 / BRAKING_S, BRAKING_MAX)
    assert told.pitch.tolist() == [pytest.approx(-np.arctan(braking / GRAVITY)), 0.0]  # nose up, against +x
