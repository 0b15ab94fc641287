"""The flight procedure: what each call leads to, what is refused, what takes over, and what is landed for."""

from dataclasses import replace

import numpy as np
import pytest
from procedure_bench import END, FIRST, HOME, PARAMS, PLAN, STEP, Bench, up, up_to

from q2q_control.flight_procedure.steps import Act, Call, Step
from q2q_model.node.reply import Reply


def test_nothing_is_ordered_without_a_call() -> None:
    bench = Bench()
    bench.wait(5.0)
    assert bench.procedure.step is Step.CHECKED
    assert bench.log[-1] == "step checked: not checked: own estimate of cf1, cf2"
    assert bench.sent == []


def test_the_whole_procedure_in_order_three_times_in_a_row() -> None:
    bench = Bench()
    for _ in range(3):
        assert bench.asked(Call.TAKE_OFF).reason == "hovering: cf1 at -0.30 m, cf2 at -0.30 m"
        assert bench.asked(Call.FLY, 2.0).granted
        assert bench.procedure.step is Step.FLIGHT
        bench.move(END)
        bench.wait(5.0)
        assert bench.procedure.step is Step.HOLD  # the plan is over
        bench.move(FIRST)
        answer = bench.asked(Call.LAND)
        assert answer == Reply(granted=True, reason="on the ground: cf1 at -0.80 m, cf2 at -0.80 m; disarmed")
        assert bench.acts == [
            Act.WAIT, Act.ARM, Act.TAKE_OFF, Act.TRANSIT, Act.STREAM, Act.START, Act.TRANSIT, Act.STOP_STREAM,
            Act.LAND, Act.DISARM,
        ]  # fmt: skip
        bench.sent.clear()
    assert bench.procedure.step is Step.CHECKED


@pytest.mark.parametrize("call", list(Call))
@pytest.mark.parametrize("step", [Step.CHECKED, Step.HOVER, Step.FLIGHT, Step.HOLD])
def test_a_call_at_the_wrong_time_is_refused_orders_nothing_and_changes_nothing(
    step: Step, call: Call
) -> None:
    right = {
        Step.CHECKED: {Call.TAKE_OFF, Call.START},
        Step.HOVER: {Call.FLY, Call.LAND},
        Step.FLIGHT: {Call.HOLD, Call.LAND},
        Step.HOLD: {Call.FLY, Call.LAND},
    }[step] | {Call.EMERGENCY}
    bench = up_to(step)
    answer = bench.call(call)
    if call in right:
        assert answer is None or answer.granted
        return
    assert answer is not None
    assert not answer.granted
    assert f"the step is {step.value}" in answer.reason
    bench.wait(1.0)
    assert bench.sent == []
    assert bench.procedure.step is step


@pytest.mark.parametrize(
    ("step", "call"), [(Step.CHECKED, Call.TAKE_OFF), (Step.CHECKED, Call.START), (Step.HOVER, Call.FLY)]
)
@pytest.mark.parametrize(
    ("unflyable", "said"),
    [
        (
            "cut",
            (
                "the controller has cut cf2 (all/emergency",
                "restart it; after missing measurements, setting stamps back by more than 1 s",
            ),
        ),
        ("without_attitude", ("cf2 was never measured upright: check the order x, y, z, w of quaternions",)),
    ],
)
def test_vehicles_that_are_cut_or_without_an_attitude_are_not_flown(
    step: Step, call: Call, unflyable: str, said: tuple[str, ...]
) -> None:
    bench = up_to(step)
    setattr(bench, unflyable, ("cf2",))
    answer = bench.call(call)
    assert answer is not None
    assert not answer.granted
    assert answer.reason.startswith(said[0])
    assert all(words in answer.reason for words in said)
    bench.wait(2.0)
    assert bench.sent == []


@pytest.mark.parametrize("step", [Step.HOVER, Step.HOLD])
@pytest.mark.parametrize(
    ("found", "why"),
    [
        ({"connected": False}, "cf2 offline: check URI, battery and radio"),
        ({"locked": True}, "cf2 is locked: restart it"),
        ({"airborne": False}, "cf2 not flying: land all, then call take_off"),
    ],
)
def test_a_plan_is_not_flown_without_one_of_its_vehicles(
    step: Step, found: dict[str, bool], why: str
) -> None:
    bench = up_to(step)
    first, second = bench.reports
    bench.reports = replace(first, airborne=True), replace(second, **found)
    assert bench.call(Call.FLY) == Reply(granted=False, reason=why)
    bench.wait(2.0)
    assert (bench.sent, bench.procedure.step) == ([], step)
    bench.reports = replace(first, airborne=True), second  # that says nothing
    assert bench.call(Call.FLY) is None


def test_a_server_that_does_not_stop_setpoints_keeps_the_vehicles_flying_them() -> None:
    bench = up_to(Step.HOLD, refuses={Act.STOP_STREAM: "all/notify_setpoints_stop does not answer"})
    answer = bench.asked(Call.LAND)
    assert not answer.granted
    assert "call land again, or emergency" in answer.reason
    assert bench.streams()
    assert bench.acts == [Act.TRANSIT, Act.STOP_STREAM]


def test_setpoints_are_flown_only_from_the_hand_over_to_the_landing() -> None:
    bench = Bench()
    assert not bench.streams()
    bench.asked(Call.TAKE_OFF)
    assert not bench.streams()
    bench.asked(Call.FLY, 2.0)
    assert bench.streams()
    bench.call(Call.LAND)
    assert not bench.streams()


def test_a_transit_that_cannot_be_certified_leaves_the_vehicles_hovering() -> None:
    words = "cf1 and cf2 would come 0.15 m into each other's zone at 1.2 s"
    bench = up_to(Step.HOVER, refuses={Act.TRANSIT: words})
    assert bench.asked(Call.FLY) == Reply(granted=False, reason=words)
    assert bench.procedure.step is Step.HOVER
    assert not bench.streams()


def test_a_plan_that_leaves_the_room_is_refused_in_the_air_too() -> None:
    bench = up_to(Step.HOVER)
    bench.plan = replace(PLAN, high=END + np.array([9.0, 0.0, 0.0]))  # trajectory was started again
    reply = bench.asked(Call.FLY)
    assert reply == Reply(
        granted=False, reason="cf1 would fly x from 2.00 to 12.00 m: the room is -1 to 3.5 m"
    )
    assert (bench.sent, bench.procedure.step) == ([], Step.HOVER)


def test_setpoints_far_from_the_vehicles_are_not_taken_over() -> None:
    bench = up_to(Step.HOVER, stuck={Act.TRANSIT})
    bench.setpoint_pos = FIRST + up(0.9)  # trajectory plays something of its own
    answer = bench.asked(Call.FLY)
    assert "cf1 is 1.40 m from its setpoint" in answer.reason
    assert bench.procedure.step is Step.HOVER
    assert bench.acts == [Act.TRANSIT]


def test_a_setpoint_that_jumps_in_flight_is_not_flown_and_all_land() -> None:
    bench = up_to(Step.FLIGHT)
    bench.setpoint_pos = bench.setpoint_pos + up(0.9)
    assert not bench.streams()
    bench.wait(6.0)
    assert any("a setpoint jumped by 0.90 m" in line for line in bench.log)
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_a_transit_whose_setpoints_rest_short_of_the_first_points_fails() -> None:
    bench = up_to(Step.HOVER)
    bench.call(Call.FLY)
    bench.wait(0.1)
    assert bench.procedure.step is Step.TRANSIT
    bench.pos = bench.setpoint_pos = FIRST - up(0.05)  # a replanner holds them off
    bench.wait(bench.params.step_timeout_s + 0.5)
    answer = bench.answer()
    assert not answer.granted
    assert "rest away from the first points" in answer.reason
    assert bench.procedure.step is Step.HOLD


def test_setpoints_that_never_rest_are_reported_and_a_second_land_lands() -> None:
    bench = up_to(Step.FLIGHT)
    bench.setpoint_vel = np.full((2, 3), 0.01)
    assert "do not come to rest" in bench.asked(Call.HOLD, bench.params.step_timeout_s + 0.5).reason
    assert bench.call(Call.LAND) is None
    bench.wait(1.0)
    assert bench.procedure.step is Step.TRANSIT
    assert bench.call(Call.LAND) is None
    bench.wait(8.0)
    assert [(call, reply.granted) for call, reply in bench.replies] == [(Call.LAND, True)]  # of both calls


def test_setpoints_that_stay_away_land_all() -> None:
    bench = up_to(Step.FLIGHT)
    bench.ignore_signals = True
    bench.wait(8.0)
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]
    assert any("no setpoint for 1.0" in line for line in bench.log)


def test_a_vehicle_to_which_nothing_is_sent_lands_all() -> None:
    bench = up_to(Step.FLIGHT)
    first, second = bench.reports
    bench.reports = first, replace(second, silent_s=1.01)
    bench.wait(8.0)
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]
    assert any("step landing: nothing sent to cf2 for 1.01 s" in line for line in bench.log)


def test_land_takes_over_from_a_fly_that_is_under_way() -> None:
    bench = up_to(Step.HOVER)
    assert bench.call(Call.FLY) is None
    assert bench.call(Call.LAND) is None
    bench.wait(6.0)
    assert bench.replies[0] == (Call.FLY, Reply(granted=False, reason="land took over"))
    assert bench.replies[1][1].granted


def test_an_emergency_cuts_from_any_step_and_lets_nothing_start_before_a_restart() -> None:
    bench = up_to(Step.FLIGHT)
    assert bench.asked(Call.EMERGENCY, 0.1).granted
    assert bench.acts == [Act.EMERGENCY]
    assert not bench.streams()
    bench.reports = tuple(replace(one, locked=True) for one in bench.reports)
    bench.move(HOME)
    bench.wait(10.0)
    refusal = bench.asked(Call.TAKE_OFF)
    assert "the step is stopped" in refusal.reason
    bench.reports = tuple(replace(one, locked=False) for one in bench.reports)
    bench.wait(6.0)
    assert bench.asked(Call.TAKE_OFF).granted


def test_a_plan_is_flown_again_from_the_hold_by_a_new_transit() -> None:
    bench = up_to(Step.HOLD)
    assert bench.asked(Call.FLY, 3.0).granted
    assert bench.acts == [Act.TRANSIT, Act.START]  # setpoints are streamed all the while


def test_a_start_joins_setpoints_at_the_vehicles_and_none_that_are_far() -> None:
    """The plan runs already: vehicles on the ground would jump to where it is."""
    bench = Bench()
    bench.setpoint_pos = HOME + np.array([[1.8, 0.0, 0.7], [0.7, 0.0, 1.9]])
    refusal = bench.asked(Call.START)
    assert "cf1 is 1.93 m from its setpoint (maximum 0.30 m): call take_off, then fly" in refusal.reason
    assert bench.sent == []
    bench.setpoint_pos = HOME.copy()
    bench.stuck = {Act.STREAM}
    assert bench.asked(Call.START, 1.0).granted
    assert bench.acts == [Act.ARM, Act.STREAM]


def test_a_start_that_is_landed_as_its_stream_begins_lands_before_it_disarms() -> None:
    bench = Bench()
    bench.call(Call.START)
    while Act.STREAM not in bench.acts:
        bench.wait(STEP)
    assert bench.procedure.step is Step.ARMING
    assert bench.call(Call.LAND) is None
    bench.wait(6.0)
    assert bench.acts == [Act.ARM, Act.STREAM, Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_a_dry_run_sends_nothing_but_an_emergency_and_says_what_would_be_sent() -> None:
    bench = Bench(params=replace(PARAMS, dry_run=True))
    answer = bench.asked(Call.TAKE_OFF)
    assert answer.granted
    assert (
        "not checked: own estimate of cf1, cf2; take_off means: let the reference rest at the vehicles, then"
        in answer.reason
    )
    assert answer.reason.endswith("then take off to -0.30 m in 2.0 s")
    assert bench.asked(Call.LAND).reason.startswith("dry run, not executed; the step is checked")
    assert bench.sent == []
    assert bench.procedure.step is Step.CHECKED
    assert bench.asked(Call.EMERGENCY).granted
    assert bench.acts == [Act.EMERGENCY]
    assert bench.procedure.step is Step.STOPPED
