"""What goes over the radio while no commands come, and how a vehicle's motors are cut."""

from dataclasses import replace

import numpy as np
import pytest
from radio_pilot_bench import HOVER, LANDING_S, NAMES, WELL, Bench
from resting_signals import level_command

from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import (
    FullState,
    RpytSetpoint,
    cut_vehicles,
)
from q2q_control.radio.link.vehicle_link import LinkHealth
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_model.signals.values import (
    CommandStatus,
)


def test_a_vehicle_without_commands_is_levelled_within_60_ms_and_lands_after_a_second() -> None:
    bench = Bench()
    bench.fly()
    bench.rpyt_setpoints()
    assert bench.silent_until(0.02, seen=True) == []
    assert set(bench.silent_until(0.04, seen=True)) == {HOVER}  # 40 and 60 ms after the last command
    assert set(bench.silent_until(0.92, seen=True)) == {HOVER}
    assert bench.pilot.phases["cf1"] is Phase.FLYING
    assert bench.silent_until(0.04, seen=True)[-1] == ("land", 0.0, LANDING_S[0])
    assert bench.pilot.phases["cf1"] is Phase.LANDING
    assert any("no command for 1.0 s" in line for line in bench.pilot.log_lines())


def test_a_vehicle_is_levelled_from_40_ms_after_its_command_and_not_before() -> None:
    bench = Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.pilot.watch(bench.t + 0.039)
    assert bench.links["cf1"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    bench.pilot.watch(bench.t + 0.041)
    assert bench.links["cf1"].sent[-1] == HOVER


def test_without_commands_and_without_a_state_a_vehicle_sinks_level_and_is_cut() -> None:
    bench = Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.silent_until(1.02, seen=False)
    sink = RpytSetpoint(0.0, 0.0, 0.0, 28200)  # 0.94 of hover: q2q_control.failsafe.fallback_phases
    assert set(bench.silent_until(3.9, seen=False)) == {sink}
    assert bench.silent_until(0.2, seen=False)[-1] == "cut"
    assert bench.pilot.phases["cf1"] is Phase.READY


@pytest.mark.parametrize(("age", "phase"), [(0.09, Phase.LANDING), (0.11, Phase.FLYING)])
def test_without_commands_a_vehicle_lands_by_a_state_that_is_not_stale(age: float, phase: Phase) -> None:
    bench = Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.t += 1.01 - age
    bench.see()
    bench.look(age)
    assert bench.pilot.phases["cf1"] is phase


def test_a_command_that_comes_before_the_landing_flies_on() -> None:
    bench = Bench()
    bench.fly()
    bench.rpyt_setpoints()
    bench.silent_until(0.9, seen=True)
    bench.rpyt_setpoints()
    assert bench.links["cf1"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    assert bench.silent_until(0.02, seen=True) == []


def test_nothing_is_sent_to_a_vehicle_that_was_never_commanded_since_its_start() -> None:
    bench = Bench()
    bench.fly()
    count = len(bench.links["cf1"].sent)
    assert bench.silent_until(3.0, seen=False) == []
    assert len(bench.links["cf1"].sent) == count
    assert bench.pilot.phases["cf1"] is Phase.FLYING


def test_by_full_states_a_silence_is_a_hover_where_it_was_sent_then_a_landing() -> None:
    bench = Bench(hover=None)
    bench.fly()
    x = (1.0, 2.0, 3.0)
    turned = (0.0, 0.0, 0.6, 0.8)
    bench.pilot.fly_full_states(NAMES, [FullState(x, x, x, turned, x)] * 2, bench.t)
    zero = (0.0, 0.0, 0.0)
    assert set(bench.silent_until(0.96, seen=False)) == {FullState(x, zero, zero, turned, zero)}
    assert bench.silent_until(0.06, seen=False)[-1] == ("land", 0.0, LANDING_S[0])


@pytest.mark.parametrize("hover", [HOVER, None])
def test_a_vehicle_whose_commands_are_not_finite_lands_and_the_other_flies_on(
    hover: RpytSetpoint | None,
) -> None:
    bench = Bench(hover=hover)
    bench.fly()
    x = (1.0, 2.0, 3.0)
    sound = FullState(x, x, x, (0.0, 0.0, 0.0, 1.0), x) if hover is None else RpytSetpoint(1.0, 2.0, 3.0, 9)

    def command(first: object) -> None:
        send = bench.pilot.fly_full_states if hover is None else bench.pilot.fly_rpyt
        send(NAMES, [first, sound], bench.t)

    command(sound)
    for _ in range(51):  # 1.02 s
        bench.t += 0.02
        bench.see()
        command(None)
        bench.pilot.watch(bench.t)
    assert bench.links["cf1"].sent.count(("land", 0.0, LANDING_S[0])) == 1
    assert bench.links["cf2"].sent[-1] == sound
    assert bench.pilot.phases == {"cf1": Phase.LANDING, "cf2": Phase.FLYING}


def test_a_command_to_cut_stops_its_vehicle_for_good_and_no_other() -> None:
    bench = Bench()
    bench.fly()
    zero = np.zeros(2)
    status = np.array([CommandStatus.CUT, CommandStatus.OK], dtype=np.uint8)
    names = cut_vehicles(level_command(0.0, NAMES, zero, status=status))
    bench.pilot.cut((*names, "stranger"), bench.t)
    bench.rpyt_setpoints()
    assert bench.links["cf1"].sent[-1] == "cut"
    assert bench.links["cf2"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)
    assert bench.pilot.phases["cf1"] is Phase.READY


def test_a_stop_is_sent_again_until_the_vehicle_says_it_is_locked() -> None:
    bench = Bench()
    bench.fly()
    link = bench.links["cf1"]
    bench.pilot.cut(("cf1",), bench.t)
    bench.look(0.1)
    assert link.sent[-2:] == ["cut", "cut"]
    link.now = replace(WELL, locked=True)
    link.sent.clear()
    bench.look(0.1)
    assert link.sent == []


def test_a_stop_is_sent_again_for_2_s_and_not_after_a_new_start() -> None:
    bench = Bench()
    bench.fly()
    bench.pilot.cut_all(bench.t)
    bench.links["cf1"].sent.clear()
    bench.look(2.1)
    assert bench.links["cf1"].sent == []
    bench.pilot.cut_all(bench.t)
    bench.pilot.begin(Order(Act.ARM), bench.t)
    bench.links["cf1"].sent.clear()
    bench.look(0.1)
    assert "cut" not in bench.links["cf1"].sent


def test_a_stop_given_while_a_link_is_down_is_delivered_when_it_is_back() -> None:
    bench = Bench()
    bench.fly()
    link = bench.links["cf2"]
    link.now = LinkHealth(connected=False)
    bench.look(0.02)
    bench.pilot.begin(Order(Act.EMERGENCY), bench.t)
    bench.look(0.0)
    for _ in range(3):
        bench.look(1.0)
    link.sent.clear()
    link.now = WELL
    for _ in range(3):
        bench.look(0.02)
    assert link.sent == ["cut"] * 3
    link.now = replace(WELL, locked=True)
    bench.look(0.02)
    link.now = WELL  # restarted
    bench.look(0.02)
    assert link.sent == ["cut"] * 3


def test_a_stop_is_sent_again_for_2_s_of_connection_over_two_losses() -> None:
    bench = Bench()
    bench.fly()
    link = bench.links["cf1"]
    bench.pilot.cut_all(bench.t)
    for now, expected in ((WELL, 9), (LinkHealth(connected=False), 9), (WELL, 17), (WELL, 17)):
        link.now = now
        for _ in range(8):
            bench.look(0.125)  # the first look after a loss counts no connection
        assert link.sent.count("cut") == expected
    assert bench.links["cf2"].sent.count("cut") == 16


def test_timeouts_out_of_order_are_refused() -> None:
    order = "command_timeout_level_s <= command_timeout_land_s <= command_timeout_stop_s"
    with pytest.raises(ValueError, match=f"; must satisfy {order}"):
        RadioPilotParams(command_timeout_land_s=6.0)


def test_a_vehicle_that_stopped_for_good_is_no_longer_flown() -> None:
    bench = Bench()
    bench.fly()
    bench.links["cf1"].now = replace(WELL, locked=True)
    bench.pilot.watch(bench.t)
    assert bench.pilot.phases["cf1"] is Phase.READY
    assert any("must be restarted" in line for line in bench.pilot.log_lines())
