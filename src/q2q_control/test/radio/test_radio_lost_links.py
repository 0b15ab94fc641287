"""A vehicle whose link is lost in the air: what it is sent then, and when it is back."""

from dataclasses import replace

from radio_pilot_bench import LANDING_S, NAMES, WELL, Bench, FakeLink

from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import RpytSetpoint
from q2q_control.radio.link.vehicle_link import LinkHealth
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_control.radio.radio_executor import RadioExecutor
from q2q_model.node.reply import Reply
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

DOWN, FLIES = LinkHealth(connected=False), replace(WELL, flying=True)


def test_a_link_lost_in_flight_is_silent_until_a_new_start_and_the_other_flies_on() -> None:
    bench = Bench()
    bench.fly()
    bench.links["cf1"].now = DOWN
    bench.pilot.watch(bench.t)
    count = len(bench.links["cf1"].sent)
    bench.rpyt_setpoints()
    for now, phase in ((WELL, Phase.OFFLINE), (replace(WELL, flying=False), Phase.READY)):
        bench.links["cf1"].now = now
        bench.pilot.watch(bench.t)
        bench.rpyt_setpoints()
        assert bench.pilot.phases == {"cf1": phase, "cf2": Phase.FLYING}
    assert len(bench.links["cf1"].sent) == count
    lost = "cf1 is lost in flight: its firmware levels out, then cuts its motors"
    assert lost in bench.pilot.log_lines()
    assert bench.links["cf2"].sent[-1] == RpytSetpoint(1.0, 2.0, 3.0, 30000)


def test_a_vehicle_that_comes_back_in_flight_lands_by_itself() -> None:
    bench = Bench()
    bench.fly()
    bench.links["cf1"].now = DOWN
    bench.look(0.02)
    bench.links["cf1"].now = FLIES
    bench.look(0.02)
    bench.rpyt_setpoints()
    assert bench.links["cf1"].sent[-1] == ("land", 0.0, LANDING_S[0])
    assert bench.pilot.phases == {"cf1": Phase.LANDING, "cf2": Phase.FLYING}


def hovering() -> Bench:
    """Return a bench whose vehicles hover at 3 m and 6 m after a take-off."""
    bench = Bench()
    bench.see()
    for act in (Act.ARM, Act.TAKE_OFF):
        assert bench.done(act).granted
    return bench


def lost_in_hover() -> Bench:
    """Return such a bench whose cf2 has lost its link."""
    bench = hovering()
    bench.links["cf2"].now = DOWN
    bench.look(0.02)
    bench.links["cf2"].sent.clear()
    return bench


def test_a_vehicle_lost_in_a_hover_is_landed_with_the_others_once_it_is_back() -> None:
    bench = lost_in_hover()
    assert "cf2 is lost in flight: its high-level commander keeps hovering" in bench.pilot.log_lines()
    bench.links["cf2"].now = FLIES
    bench.look(0.02)
    assert set(bench.pilot.phases.values()) == {Phase.CLIMBING}
    bench.done(Act.LAND)
    assert bench.links["cf2"].sent == [("land", 0.0, LANDING_S[1])]
    assert set(bench.pilot.phases.values()) == {Phase.LANDING}


def test_a_landing_ordered_while_a_link_is_lost_is_sent_at_once_and_when_it_is_back() -> None:
    bench = lost_in_hover()
    bench.done(Act.LAND)
    assert bench.links["cf2"].sent == [("land", 0.0, LANDING_S[1])]
    assert bench.pilot.landing_left(bench.t + 1.0) == LANDING_S[1] - 1.0  # an end waits for it
    bench.look(3.0)
    bench.links["cf2"].now = FLIES
    bench.look(0.02)
    assert bench.links["cf2"].sent == [("land", 0.0, LANDING_S[1])] * 2
    assert set(bench.pilot.phases.values()) == {Phase.LANDING}


def test_a_vehicle_that_comes_back_locked_is_on_the_ground_though_it_does_not_say_whether_it_flies() -> None:
    bench = lost_in_hover()
    bench.links["cf2"].now = replace(WELL, locked=True)
    bench.look(0.02)
    assert bench.links["cf2"].sent == []
    assert bench.pilot.phases == {"cf1": Phase.CLIMBING, "cf2": Phase.READY}


def test_a_vehicle_lost_in_a_hover_is_cut_at_once_and_when_it_is_back() -> None:
    bench = lost_in_hover()
    bench.pilot.cut(("cf2",), bench.t)
    assert bench.links["cf2"].sent == ["cut"]
    bench.links["cf2"].now = FLIES
    bench.look(3.0)
    assert bench.links["cf2"].sent == ["cut"] * 2
    assert bench.pilot.phases == {"cf1": Phase.CLIMBING, "cf2": Phase.READY}


def test_a_stop_succeeds_once_all_are_locked() -> None:
    bench = hovering()
    bench.pilot.begin(Order(Act.EMERGENCY), bench.t)
    bench.look(0.02)
    assert bench.pilot.outcome(bench.t) is None
    for link in bench.links.values():
        link.now = replace(WELL, locked=True)
    bench.look(0.02)
    assert bench.pilot.outcome(bench.t) == Reply(granted=True)


def test_a_stop_fails_with_the_vehicles_that_are_lost_before_they_are_locked() -> None:
    bench = hovering()
    bench.pilot.begin(Order(Act.EMERGENCY), bench.t)
    bench.look(0.02)
    bench.links["cf1"].now, bench.links["cf2"].now = replace(WELL, locked=True), DOWN
    bench.look(0.02)
    reply = bench.pilot.outcome(bench.t)
    assert reply is not None
    assert not reply.granted
    assert reply.reason.startswith("cf2 not reached: ")
    assert "motors of cf1 stopped" in reply.reason


def test_a_stop_with_firmware_that_never_locks_succeeds_after_it_was_sent_for_2_s() -> None:
    bench = hovering()
    bench.pilot.begin(Order(Act.EMERGENCY), bench.t)
    bench.look(1.98)
    assert bench.pilot.outcome(bench.t) is None
    bench.look(0.04)
    assert bench.pilot.outcome(bench.t) == Reply(granted=True)


def test_a_vehicle_that_others_fly_is_not_landed_when_it_is_connected() -> None:
    bench = Bench(links={name: FakeLink(DOWN) for name in NAMES})
    for link in bench.links.values():
        link.now = FLIES
    bench.look(0.02)
    assert set(bench.pilot.phases.values()) == {Phase.READY}
    assert not bench.pilot.land(bench.t)


def test_a_report_says_whether_a_vehicle_is_in_the_air_for_the_plan() -> None:
    bench = hovering()
    executor = RadioExecutor(bench.pilot, bench.links, CRAZYFLIE_2_0)
    assert [one.airborne for one in executor.reports()] == [True, True]
    bench.links["cf1"].now = replace(WELL, flying=False)
    assert [one.airborne for one in executor.reports()] == [False, True]
    bench.pilot.land(bench.t)
    assert [one.airborne for one in executor.reports()] == [False, False]
