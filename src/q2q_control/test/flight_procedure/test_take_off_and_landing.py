"""The flight procedure refuses take-offs and confirms landings by what vehicles report."""

import re
from dataclasses import replace

import numpy as np
import pytest
from procedure_bench import END, FIRST, GROUND, HOME, PLAN, STEP, WELL, Bench, at_height, up, up_to

from q2q_control.flight_procedure.checks.arrival import heights_text
from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Act, Call, Order, Step
from q2q_model.node.reply import Reply

BAD: list[tuple[dict[str, object], str]] = [
    ({"reports": (WELL, VehicleReport("cf2", connected=False))}, "cf2 offline"),
    ({"reports": (WELL, replace(WELL, name="cf2", locked=True))}, "cf2 is locked: restart it"),
    ({"reports": (WELL, replace(WELL, name="cf2", volt=3.41))}, r"cf2 has 3\.41 V \(minimum 3\.60 V to"),
    ({"reports": (WELL, replace(WELL, name="cf2", volt=np.nan))},
     "cf2 does not report its battery: wait for its first report, or enable its log$"),
    ({"reports": (WELL, replace(WELL, name="cf2", wrong="stabilizer.controller is 1, 2 is asked"))},
     "cf2: stabilizer.controller is 1, 2 is asked"),
    ({"reports": (WELL, replace(WELL, name="cf2", onboard=tuple(HOME[1] - up(0.25))))},
     r"cf2 estimates itself 0\.25 m from its measured position"),
    ({"reports": (WELL, replace(WELL, name="cf2", hover_ratio=0.73))},
     r"cf2 would be sent 73 % of the thrust at which it hovers \(allowed within 15 %\)"),
    ({"reports": (WELL, replace(WELL, name="cf2", hover_ratio=1.16))},
     r"cf2 would be sent 116 % of the thrust"),
    ({"pos": HOME + up(0.11)}, r"cf1 is 0\.11 m above the ground"),
    ({"pos": HOME - up(0.11)}, r"cf1 is -0\.11 m above the ground"),
    ({"vel": np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])}, r"cf2 moves at 0\.20 m/s"),
    ({"pos": HOME[0] + [[0.0, 0.0, -0.09], [-0.168, 0.224, 0.09]]},
     r"cf1 and cf2 are 0\.28 m apart \(minimum 0\.30 m\)"),
    ({"pos": HOME + np.array([0.0, 0.4, 0.0])}, r"cf1 is 0\.40 m from its first point \(maximum 0\.30 m\)"),
    ({"plan": None}, "no plan is waiting"),
    ({"plan": replace(PLAN, names=("cf1", "cf9"))}, "the plan lacks cf2 and has cf9: .* cf1, cf2"),
    ({"plan": replace(PLAN, high=END + np.array([0.0, 3.0, 0.0]))},
     r"cf2 would fly y from 0\.20 to 3\.20 m: .* -2 to 3 m"),
    ({"plan": replace(PLAN, low=END - np.array([0.0, 1.5, 0.0]))},
     r"cf1 would fly y from -2\.50 to -1\.00 m"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "log"), BAD, ids=[log for _, log in BAD])
def test_take_off_is_refused_with_vehicle_and_number_and_nobody_arms(
    given: dict[str, object], log: str
) -> None:
    bench = Bench()
    for name, value in given.items():
        setattr(bench, name, value)
    answer = bench.asked(Call.TAKE_OFF)
    assert not answer.granted
    assert re.search(log, answer.reason), answer.reason
    assert bench.sent == []


def test_an_old_state_refuses_the_take_off() -> None:
    bench = Bench(unmeasured=True)
    bench.wait(0.3)
    assert "cf1 has no state younger than 0.1 s (its last is 0.32 s old)" in bench.asked(Call.TAKE_OFF).reason


def test_vehicles_that_do_not_arm_are_disarmed_again_and_named() -> None:
    bench = Bench(refuses={Act.ARM: "cf2 did not arm within 2 s"})
    answer = bench.asked(Call.TAKE_OFF)
    assert answer == Reply(granted=False, reason="cf2 did not arm within 2 s")
    assert bench.acts == [Act.WAIT, Act.ARM, Act.DISARM]
    assert bench.procedure.step is Step.CHECKED


def test_a_take_off_that_does_not_arrive_is_landed_and_says_where_the_vehicle_is() -> None:
    bench = Bench(stuck={Act.TAKE_OFF})
    answer = bench.asked(Call.TAKE_OFF, 11.0)
    assert "take-off failed: cf1 is at -0.80 m, 0.50 m from its goal; landing" in answer.reason
    assert bench.acts[-3:] == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def ordered_to_take_off(**given: object) -> Bench:
    """Return a bench whose vehicles have just been told to take off."""
    bench = Bench(**given)
    bench.call(Call.TAKE_OFF)
    while Act.TAKE_OFF not in bench.acts:
        bench.wait(STEP)
    return bench


def test_a_take_off_that_arrives_too_late_to_rest_says_so() -> None:
    bench = ordered_to_take_off(stuck={Act.TAKE_OFF})
    bench.wait(bench.params.take_off_s + bench.params.step_timeout_s - 0.3)
    bench.move(HOME + up(0.5))
    bench.wait(8.0)
    held = r"it has stayed within 0\.1 m of one place and below 0\.25 m/s for 0\.\d+ s \(minimum 1 s\)"
    assert re.fullmatch(f"take-off failed: cf1 still moves: {held}; landing", bench.answer().reason)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_vehicle_that_hovers_beside_where_it_stood_has_not_taken_off(axis: int) -> None:
    bench = ordered_to_take_off(stuck={Act.TAKE_OFF})
    beside = HOME + up(0.5)
    beside[1, axis] += 0.2
    bench.move(beside)
    bench.wait(8.0)
    assert bench.answer().reason.startswith("take-off failed: cf2 is at -0.30 m, 0.20 m from its goal")


def test_a_vehicle_that_swings_above_where_it_stood_has_not_taken_off() -> None:
    bench = ordered_to_take_off(stuck={Act.TAKE_OFF})
    rate = 2.0 * np.pi / 3.0  # [rad/s]: 0.63 m/s at most
    while not bench.replies:
        swung, speed = 0.3 * np.sin(rate * bench.t), 0.3 * rate * np.cos(rate * bench.t)
        bench.move(HOME + np.array([[swung, 0.0, 0.5], [0.0, 0.0, 0.5]]))
        bench.vel = np.array([[speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
        bench.wait(STEP)
    assert bench.answer().reason.startswith("take-off failed: cf1 ")


def test_vehicles_are_landed_before_they_are_disarmed_where_a_take_off_is_told_to_have_failed() -> None:
    bench = ordered_to_take_off(refuses={Act.TAKE_OFF: "no answer from all/takeoff"})
    bench.move(HOME + up(0.5))
    bench.wait(8.0)
    assert bench.answer() == Reply(granted=False, reason="no answer from all/takeoff; landing")
    assert bench.acts[-3:] == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_a_landing_is_confirmed_only_on_the_ground() -> None:
    bench = up_to(Step.HOLD, stuck={Act.LAND})
    answer = bench.asked(Call.LAND, 12.0)
    assert not answer.granted
    assert "not on the ground: cf1 is at 0.20 m, 1.00 m from its goal" in answer.reason
    assert Act.DISARM not in bench.acts
    bench.stuck.clear()
    assert bench.asked(Call.LAND).granted  # called again, it lands


def test_a_landing_that_ends_at_the_last_moment_is_waited_for() -> None:
    bench = up_to(Step.HOLD, stuck={Act.LAND})
    bench.call(Call.LAND)
    while not bench.replies:
        late = bench.t
        bench.wait(STEP)
    again = up_to(Step.HOLD, stuck={Act.LAND})
    again.call(Call.LAND)
    again.wait(late - again.t)
    again.move(at_height(again.pos, GROUND))
    again.wait(8.0)
    assert again.answer().granted


def test_vehicles_that_overlap_transit_apart_before_they_land() -> None:
    bench = up_to(Step.HOLD)
    bench.move(FIRST[0] + np.array([[0.0, 0.0, 0.0], [0.06, -0.08, 0.5]]))
    bench.call(Call.LAND)
    bench.wait(STEP)
    assert bench.acts == [Act.TRANSIT]
    bench.move(FIRST)
    bench.wait(6.0)
    assert bench.answer().granted
    assert bench.acts == [Act.TRANSIT, Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_a_landing_takes_as_long_as_the_highest_vehicle_needs_above_the_ground() -> None:
    bench = up_to(Step.FLIGHT)
    first, second = FIRST
    bench.move(np.array([first, second + up(0.6)]))
    assert bench.asked(Call.LAND).granted
    assert bench.sent[1] == Order(Act.LAND, GROUND, pytest.approx(1.6 / 0.4))
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_vehicles_that_land_by_themselves_are_watched_to_the_ground() -> None:
    bench = up_to(Step.FLIGHT)
    bench.reports = tuple(replace(one, flies=False) for one in bench.reports)
    bench.wait(STEP)
    assert bench.procedure.step is Step.LANDING
    bench.move(HOME)
    bench.wait(4.0)
    assert bench.acts == [Act.DISARM]
    assert "step landing: by themselves" in bench.log


def test_vehicles_whose_motors_were_cut_are_not_told_to_land_by_themselves() -> None:
    bench = up_to(Step.FLIGHT)
    bench.reports = tuple(replace(one, flies=False, cut=True) for one in bench.reports)
    bench.wait(STEP)
    assert bench.log[-1] == "step landing: motors of cf1, cf2 stopped"


def test_a_cut_vehicle_is_named_while_the_other_lands_by_itself() -> None:
    bench = up_to(Step.FLIGHT)
    first, second = (replace(one, flies=False) for one in bench.reports)
    bench.reports = first, replace(second, cut=True)
    bench.wait(STEP)
    assert bench.log[-1] == "step landing: motors of cf2 stopped"


def test_vehicles_that_were_never_locked_were_not_restarted() -> None:
    bench = up_to(Step.HOVER)
    assert bench.asked(Call.EMERGENCY, 60.0).granted
    assert bench.procedure.step is Step.STOPPED


def test_after_an_emergency_each_vehicle_must_have_been_locked_or_offline() -> None:
    bench = up_to(Step.HOVER)
    first, second = bench.reports
    bench.reports = replace(first, locked=True), second
    bench.asked(Call.EMERGENCY)
    bench.reports = first, second
    bench.wait(6.0)
    assert bench.procedure.step is Step.STOPPED  # cf2 was never locked
    bench.reports = first, replace(second, connected=False)
    bench.wait(6.0)
    bench.reports = first, second  # back, and not yet cut
    bench.wait(0.4)
    bench.reports = first, replace(second, locked=True)
    bench.wait(6.0)
    assert bench.procedure.step is Step.STOPPED
    bench.reports = first, second
    bench.wait(bench.params.settle_s + 0.1)
    assert bench.procedure.step is Step.CONNECTED
    assert "step connected: vehicles were restarted" in bench.log


def test_a_vehicle_measured_just_below_the_floor_is_at_0_m() -> None:
    observation = replace(Bench().observe(), pos=at_height(HOME, -0.001))
    assert heights_text(observation) == "cf1 at 0.00 m, cf2 at 0.00 m"


def test_the_heights_of_many_vehicles_are_those_of_the_first_ones() -> None:
    vehicles = tuple(replace(WELL, name=f"cf{k}") for k in range(30))
    text = heights_text(replace(Bench().observe(), vehicles=vehicles, pos=np.zeros((30, 3))))
    assert text.startswith("cf0 at 0.00 m, cf1 at 0.00 m")
    assert text.endswith("cf19 at 0.00 m, and 10 more")
