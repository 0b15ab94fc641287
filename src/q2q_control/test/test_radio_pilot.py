"""What goes over the radio, and when: words of cflib, refusals, landings, lost links."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link import LinkHealth
from q2q_control.radio.pilot_params import RadioPilotParams
from q2q_control.radio.radio_executor import RadioExecutor
from q2q_control.radio.radio_pilot import RadioPilot
from q2q_control.radio.setpoints import (
    ZERO_RPYT,
    FullState,
    RpytSetpoint,
    names_cut,
)
from q2q_control.radio.vehicle_record import Phase
from q2q_model.node.reply import Reply
from q2q_model.signals.values import (
    CommandStatus,
    SwarmCommand,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

NAMES = ("cf1", "cf2")
WELL = LinkHealth(connected=True, volt=4.0, armed=True)
PARAMS = RadioPilotParams()
LANDING_S = 3.0 / 0.4, 6.0 / 0.4
"""From 3 m and 6 m at 0.4 m/s."""
HOVER = RpytSetpoint(0.0, 0.0, 0.0, 30000)


@dataclass
class _FakeLink:
    """Write down what is sent."""

    now: LinkHealth = WELL
    sent: list[object] = field(default_factory=list)

    def health(self) -> LinkHealth:
        return self.now

    def send_rpyt(self, stick: RpytSetpoint) -> None:
        self.sent.append(stick)

    def send_full_state(self, demanded: FullState) -> None:
        self.sent.append(demanded)

    def send_place(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        self.sent.append(("place", tuple(pos), tuple(quat)))

    def arm(self) -> None:
        self.sent.append("arm")

    def disarm(self) -> None:
        self.sent.append("disarm")

    def take_off(self, height: float, duration: float) -> None:
        self.sent.append(("take off", height, duration))

    def land(self, duration: float) -> None:
        self.sent.append(("land", duration))

    def stop(self) -> None:
        self.sent.append("stop")


@dataclass
class _Bench:
    """Links of two vehicles and the pilot, at a time set by tests."""

    links: dict[str, _FakeLink] = field(default_factory=lambda: {name: _FakeLink() for name in NAMES})
    t: float = 100.0
    hover: RpytSetpoint | None = HOVER

    def __post_init__(self) -> None:
        self.pilot = RadioPilot(self.links, PARAMS, self.hover)
        self.pilot.watch(self.t)

    def see(self, status: TrackStatus = TrackStatus.TRACKED) -> None:
        self.pilot.update_state(state(self.t, status), self.t)

    def fly(self) -> None:
        self.see()
        for act in (Act.ARM, Act.STREAM):
            assert self.done(act).granted
        assert set(self.pilot.phases.values()) == {Phase.FLYING}

    def done(self, act: Act) -> Reply:
        """Give an order and return what became of it."""
        self.pilot.begin(Order(act, 0.5, 2.0), self.t)
        self.pilot.watch(self.t)
        reply = self.pilot.outcome(self.t)
        assert reply is not None
        return reply

    def rpyt_setpoints(self) -> None:
        self.pilot.fly_rpyt(NAMES, [RpytSetpoint(1.0, 2.0, 3.0, 30000)] * 2, self.t)

    def look(self, later: float) -> None:
        """Look once, so much later [s]."""
        self.t += later
        self.pilot.watch(self.t)

    def silent_until(self, age: float, *, seen: bool) -> list[object]:
        """Look every 20 ms until the last command is `age` old; return what cf1 was sent."""
        began = self.t
        before = len(self.links["cf1"].sent)
        while self.t < began + age - 1e-9:
            self.t += 0.02
            if seen:
                self.see()
            self.pilot.watch(self.t)
        sent = self.links["cf1"].sent[before:]
        return [one for one in sent if not (isinstance(one, tuple) and one[0] == "place")]


def state(t: float, status: TrackStatus = TrackStatus.TRACKED) -> SwarmState:
    zero, quat = np.zeros((2, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    pos = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    return SwarmState(t, NAMES, pos, zero, quat, zero, np.zeros(2), np.full(2, status, dtype=np.uint8))


def test_arming_unlocks_and_only_streamed_vehicles_are_sent_commands() -> None:
    bench = _Bench()
    bench.rpyt_setpoints()
    assert bench.done(Act.ARM).granted
    bench.rpyt_setpoints()
    assert bench.done(Act.TAKE_OFF).granted
    bench.rpyt_setpoints()
    assert set(bench.pilot.phases.values()) == {Phase.CLIMBING}
    bench.done(Act.STREAM)
    bench.rpyt_setpoints()
    assert bench.links["cf2"].sent == [
        "arm",
        ZERO_RPYT,
        ("take off", 0.5, 2.0),
        RpytSetpoint(1.0, 2.0, 3.0, 30000),
    ]


def test_a_vehicle_that_does_not_arm_in_time_is_named() -> None:
    bench = _Bench()
    bench.links["cf1"].now = replace(WELL, armed=False)
    bench.pilot.begin(Order(Act.ARM), bench.t)
    bench.pilot.watch(bench.t + 1.9)
    assert bench.pilot.outcome(bench.t + 1.9) is None
    bench.pilot.watch(bench.t + 2.1)
    assert bench.pilot.outcome(bench.t + 2.1) == Reply(granted=False, reason="cf1 did not arm within 2 s")
    assert bench.pilot.outcome(bench.t + 2.1) is None  # told once


def test_disarming_is_done_when_no_vehicle_is_armed_and_says_who_arms_itself() -> None:
    bench = _Bench()
    bench.done(Act.ARM)
    bench.pilot.begin(Order(Act.DISARM), bench.t)
    assert bench.pilot.outcome(bench.t + 1.9) is None
    bench.links["cf1"].now = replace(WELL, armed=False)
    reply = bench.pilot.outcome(bench.t + 2.1)
    assert reply == Reply(granted=False, reason="cf2 armed again: the build arms itself")
    assert [link.sent[-1] for link in bench.links.values()] == ["disarm", "disarm"]


def test_a_pilot_as_crew_reports_what_its_links_and_phases_say() -> None:
    bench = _Bench()
    bench.fly()
    bench.links["cf2"].now = replace(WELL, volt=3.3, onboard=(1.0, 2.0, 3.0), wrong="mass is 0")
    first, second = RadioExecutor(bench.pilot, bench.links, CRAZYFLIE_2_0).reports()
    assert (first.name, first.connected, first.armed, first.flies) == ("cf1", True, True, True)
    assert (second.volt, second.onboard, second.wrong) == (3.3, (1.0, 2.0, 3.0), "mass is 0")


def test_a_link_lost_in_flight_is_silent_until_a_new_start_and_the_other_flies_on() -> None:
    bench = _Bench()
    bench.fly()
    bench.links["cf1"].now = LinkHealth(connected=False)
    bench.pilot.watch(bench.t)
    count = len(bench.links["cf1"].sent)
    bench.rpyt_setpoints()
    bench.links["cf1"].now = WELL
    bench.pilot.watch(bench.t)
    bench.rpyt_setpoints()
    assert len(bench.links["cf1"].sent) == count
    assert bench.pilot.phases == {"cf1": Phase.READY, "cf2": Phase.FLYING}
    assert any("cf1 is lost in flight" in line for line in bench.pilot.log_lines())
    assert bench.links["cf2"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)


def test_a_low_battery_lands_its_vehicle_after_a_while_whatever_is_commanded() -> None:
    bench = _Bench()
    bench.fly()
    bench.links["cf2"].now = replace(WELL, volt=3.1)
    bench.pilot.watch(bench.t)
    bench.links["cf2"].now = WELL  # a dip under load is forgiven
    bench.pilot.watch(bench.t + 1.0)
    bench.links["cf2"].now = replace(WELL, volt=3.1)
    bench.pilot.watch(bench.t + 1.5)
    bench.pilot.watch(bench.t + 3.4)
    assert bench.pilot.phases["cf2"] is Phase.FLYING
    bench.pilot.watch(bench.t + 3.5)
    assert bench.pilot.phases == {"cf1": Phase.FLYING, "cf2": Phase.LANDING}
    bench.rpyt_setpoints()
    assert bench.links["cf2"].sent[-1] == ("land", LANDING_S[1])
    bench.pilot.watch(bench.t + 3.5 + LANDING_S[1] - 0.1)
    assert bench.pilot.phases["cf2"] is Phase.LANDING
    bench.pilot.watch(bench.t + 3.5 + LANDING_S[1] + 0.1)
    assert bench.pilot.phases["cf2"] is Phase.READY


def test_a_vehicle_without_commands_is_levelled_within_60_ms_and_lands_after_a_second() -> None:
    bench = _Bench()
    bench.fly()
    bench.rpyt_setpoints()
    assert bench.silent_until(0.02, seen=True) == []
    assert set(bench.silent_until(0.04, seen=True)) == {HOVER}  # 40 and 60 ms after the last command
    assert set(bench.silent_until(0.92, seen=True)) == {HOVER}
    assert bench.pilot.phases["cf1"] is Phase.FLYING
    assert bench.silent_until(0.04, seen=True)[-1] == ("land", LANDING_S[0])
    assert bench.pilot.phases["cf1"] is Phase.LANDING
    assert any("no command for 1.0 s" in line for line in bench.pilot.log_lines())


def test_a_vehicle_is_levelled_from_40_ms_after_its_command_and_not_before() -> None:
    bench = _Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.pilot.watch(bench.t + 0.039)
    assert bench.links["cf1"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    bench.pilot.watch(bench.t + 0.041)
    assert bench.links["cf1"].sent[-1] == HOVER


def test_without_commands_and_without_a_state_a_vehicle_sinks_level_and_is_stopped() -> None:
    bench = _Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.silent_until(1.02, seen=False)
    sink = RpytSetpoint(0.0, 0.0, 0.0, 28200)  # 0.94 of hover: q2q_control.failsafe.ladder
    assert set(bench.silent_until(3.9, seen=False)) == {sink}
    assert bench.silent_until(0.2, seen=False)[-1] == "stop"
    assert bench.pilot.phases["cf1"] is Phase.READY


def test_a_command_that_comes_before_the_landing_flies_on() -> None:
    bench = _Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.silent_until(0.9, seen=True)
    bench.rpyt_setpoints()
    assert bench.links["cf1"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    assert bench.silent_until(0.02, seen=True) == []


def test_nothing_is_sent_to_a_vehicle_that_was_never_commanded_since_its_start() -> None:
    bench = _Bench()
    bench.fly()
    count = len(bench.links["cf1"].sent)
    assert bench.silent_until(3.0, seen=False) == []
    assert len(bench.links["cf1"].sent) == count
    assert bench.pilot.phases["cf1"] is Phase.FLYING


def test_by_full_states_a_silence_is_a_hover_where_it_was_sent_then_a_landing() -> None:
    bench = _Bench(hover=None)
    bench.fly()
    x = (1.0, 2.0, 3.0)
    turned = (0.0, 0.0, 0.6, 0.8)
    bench.pilot.fly_full_states(NAMES, [FullState(x, x, x, turned, x)] * 2, bench.t)
    zero = (0.0, 0.0, 0.0)
    assert set(bench.silent_until(0.96, seen=False)) == {FullState(x, zero, zero, turned, zero)}
    assert bench.silent_until(0.06, seen=False)[-1] == ("land", LANDING_S[0])


def test_a_command_to_cut_stops_its_vehicle_for_good_and_no_other() -> None:
    bench = _Bench()
    bench.fly()
    zero = np.zeros(2)
    status = np.array([CommandStatus.CUT, CommandStatus.OK], dtype=np.uint8)
    names = names_cut(SwarmCommand(0.0, NAMES, zero, zero, zero, zero, status))
    bench.pilot.cut((*names, "stranger"), bench.t)
    bench.rpyt_setpoints()
    assert bench.links["cf1"].sent[-1] == "stop"
    assert bench.links["cf2"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    assert bench.pilot.phases["cf1"] is Phase.READY


def test_a_stop_is_sent_again_until_the_vehicle_says_it_is_locked() -> None:
    bench = _Bench()
    bench.fly()
    link = bench.links["cf1"]
    bench.pilot.cut(("cf1",), bench.t)
    bench.look(0.1)
    assert link.sent[-2:] == ["stop", "stop"]
    link.now = replace(WELL, locked=True)
    link.sent.clear()
    bench.look(0.1)
    assert link.sent == []


def test_a_stop_is_sent_again_for_2_s_and_not_after_a_new_start() -> None:
    bench = _Bench()
    bench.fly()
    bench.pilot.stop(bench.t)
    bench.links["cf1"].sent.clear()
    bench.look(2.1)
    assert bench.links["cf1"].sent == []
    bench.pilot.stop(bench.t)
    bench.pilot.begin(Order(Act.ARM), bench.t)
    bench.links["cf1"].sent.clear()
    bench.look(0.1)
    assert "stop" not in bench.links["cf1"].sent


def test_a_landing_takes_as_long_as_the_height_asks_for_and_no_less_than_land_s() -> None:
    bench = _Bench()
    bench.fly()
    low = state(bench.t)
    low.pos[:, 2] = [0.5, 2.0]
    bench.pilot.update_state(low, bench.t)
    bench.pilot.land(bench.t)
    least = LandingParams().land_s
    assert [bench.links[name].sent[-1] for name in NAMES] == [("land", least), ("land", 2.0 / 0.4)]
    assert bench.pilot.landing_s == 2.0 / 0.4


def test_times_of_silence_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="must rise"):
        RadioPilotParams(silent_land_s=6.0)


def test_a_battery_that_is_unknown_lands_nobody() -> None:
    bench = _Bench()
    for link in bench.links.values():
        link.now = replace(WELL, volt=math.nan)
    bench.fly()
    bench.pilot.watch(bench.t + 100.0)
    assert set(bench.pilot.phases.values()) == {Phase.FLYING}


def test_land_lands_those_who_fly_and_stop_stops_all() -> None:
    bench = _Bench()
    assert not bench.pilot.land(bench.t)
    bench.fly()
    assert bench.pilot.land(bench.t)
    assert set(bench.pilot.phases.values()) == {Phase.LANDING}
    bench.pilot.stop(bench.t)
    assert all(link.sent[-1] == "stop" for link in bench.links.values())
    bench.rpyt_setpoints()
    assert all(link.sent[-1] == "stop" for link in bench.links.values())


def test_a_vehicle_that_stopped_for_good_is_no_longer_flown() -> None:
    bench = _Bench()
    bench.fly()
    bench.links["cf1"].now = replace(WELL, locked=True)
    bench.pilot.watch(bench.t)
    assert bench.pilot.phases["cf1"] is Phase.READY
    assert any("must be restarted" in line for line in bench.pilot.log_lines())


def test_places_are_sent_once_a_frame_and_only_where_measured() -> None:
    bench = _Bench()
    for t in (1.0, 1.0, 1.01):
        bench.pilot.update_state(state(t), bench.t)
    bench.pilot.update_state(state(1.02, TrackStatus.COASTING), bench.t)
    expected = ("place", (4.0, 5.0, 6.0), (0.0, 0.0, 0.0, 1.0))
    assert bench.links["cf2"].sent == [expected, expected]


def test_places_are_moved_on_by_their_delay() -> None:
    bench, seen = _Bench(), state(1.0)
    turning = replace(seen, vel=seen.pos / 4.0, ang_vel_body=np.tile([0.0, 0.0, 5.0], (2, 1)))
    bench.pilot.update_state(turning, bench.t)
    ((_, pos, quat),) = bench.links["cf2"].sent
    delay = PARAMS.pose_delay_s
    assert pos == pytest.approx([4.0 + delay, 5.0 + 1.25 * delay, 6.0 + 1.5 * delay])
    assert quat == pytest.approx([0.0, 0.0, math.sin(2.5 * delay), math.cos(2.5 * delay)])


def test_a_place_that_is_no_number_and_a_stranger_are_passed_over() -> None:
    bench = _Bench()
    one = state(1.0)
    one.pos[0, 1] = np.nan
    bench.pilot.update_state(replace(one, names=("cf1", "stranger")), bench.t)
    assert bench.links["cf1"].sent == bench.links["cf2"].sent == []
