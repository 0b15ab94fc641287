"""The flight procedure: what each call leads to, what is refused, what takes over, and what is landed for."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from q2q_control.flight_procedure.observation import Observation, PlanOutline, VehicleReport
from q2q_control.flight_procedure.procedure import FlightProcedure
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.rest import places
from q2q_control.flight_procedure.steps import Act, Call, Order, Step
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Array

NAMES = ("cf1", "cf2")
HOME = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
FIRST = HOME + np.array([0.0, 0.0, 1.0])
END = FIRST + np.array([1.0, 0.0, 0.0])
PLAN = PlanOutline(NAMES, FIRST, FIRST, END, duration=4.0)
WELL = VehicleReport(
    "cf1", connected=True, volt=4.0, armed=True, locked=False, wrong="", onboard=None, hover_ratio=1.0
)
STEP = 0.02


def up(metres: float) -> Array:
    return np.array([0.0, 0.0, metres])


@dataclass
class _Bench:
    """Vehicles that do at once what they are told, unless `stuck`, and the procedure that tells them."""

    params: FlightProcedureParams = field(default_factory=FlightProcedureParams)
    t: float = 100.0
    pos: Array = field(default_factory=HOME.copy)
    vel: Array = field(default_factory=lambda: np.zeros((2, 3)))
    setpoint_pos: Array = field(default_factory=HOME.copy)
    setpoint_vel: Array = field(default_factory=lambda: np.zeros((2, 3)))
    seen_at: float = 100.0
    heard_at: float = 100.0
    blind: bool = False
    ignore_signals: bool = False
    reports: tuple[VehicleReport, ...] = (WELL, replace(WELL, name="cf2"))
    plan: PlanOutline | None = PLAN
    refuses: dict[Act, str] = field(default_factory=dict)
    stuck: set[Act] = field(default_factory=set)
    sent: list[Order] = field(default_factory=list)
    replies: list[tuple[Call, Reply]] = field(default_factory=list)
    log: list[str] = field(default_factory=list)
    outcome: Reply | None = None

    def __post_init__(self) -> None:
        self.procedure = FlightProcedure(self.params, LandingParams())
        self.wait(STEP)

    def observe(self) -> Observation:
        return Observation(
            self.reports, self.pos, self.vel, np.full(2, self.t - self.seen_at), self.setpoint_pos,
            self.setpoint_vel, self.t - self.heard_at, self.plan,
        )  # fmt: skip

    def call(self, call: Call) -> Reply | None:
        return self.procedure.call(call, self.observe(), self.t)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.t += STEP
            self.seen_at = self.seen_at if self.blind else self.t
            if not self.ignore_signals:
                self.heard_at = self.t
                self.procedure.accepts(self.setpoint_pos)
            self.procedure.update(self.observe(), self.outcome, self.t)
            self.outcome = None
            for order in self.procedure.state.take_orders():
                self._obey(order)
            self.replies += self.procedure.state.take_replies()
            self.log += self.procedure.state.take_log()

    def answer(self) -> Reply:
        assert len(self.replies) == 1, self.replies
        return self.replies.pop()[1]

    def asked(self, call: Call, seconds: float = 8.0) -> Reply:
        """Call, let time pass, and return the answer."""
        at_once = self.call(call)
        self.wait(seconds if at_once is None else STEP)
        return self.answer() if at_once is None else at_once

    @property
    def acts(self) -> list[Act]:
        return [order.act for order in self.sent]

    def _obey(self, order: Order) -> None:
        self.sent.append(order)
        self.outcome = Reply(order.act not in self.refuses, self.refuses.get(order.act, ""))
        if order.act in self.stuck or order.act in self.refuses:
            return
        moves: dict[Act, Callable[[], None]] = {
            Act.TAKE_OFF: lambda: self.move(HOME + up(order.height)),
            Act.GLIDE: lambda: self.move(FIRST if self.procedure.step is Step.HOLD else self.pos),
            Act.STREAM: lambda: self.move(FIRST),
            Act.START: lambda: None,
            Act.LAND: lambda: self.move(self.pos * [1.0, 1.0, 0.0]),
        }
        moves.get(order.act, lambda: None)()

    def move(self, pos: Array) -> None:
        """Put vehicles and setpoints somewhere, within what a setpoint may move in a tick."""
        self.pos, self.setpoint_pos = pos.copy(), pos.copy()
        self.procedure.accepts(np.full((2, 3), np.nan))


def up_to(step: Step, **given: object) -> _Bench:
    """Return a bench whose procedure has come to a step."""
    bench = _Bench(**given)
    road = {Step.HOVER: [Call.TAKE_OFF], Step.FLIGHT: [Call.TAKE_OFF, Call.FLY],
            Step.HOLD: [Call.TAKE_OFF, Call.FLY, Call.HOLD]}  # fmt: skip
    for call in road.get(step, []):
        assert bench.asked(call, 3.0).granted
    assert bench.procedure.step is step
    bench.sent.clear()
    return bench


def test_nothing_is_ordered_without_a_call() -> None:
    bench = _Bench()
    bench.wait(5.0)
    assert bench.procedure.step is Step.CHECKED
    assert bench.log[-1] == "step checked: not checked: own estimate of cf1, cf2"
    assert bench.sent == []


def test_the_whole_procedure_in_order_three_times_in_a_row() -> None:
    bench = _Bench()
    for _ in range(3):
        assert bench.asked(Call.TAKE_OFF).reason == "hovering: cf1 at 0.50 m, cf2 at 0.50 m"
        assert bench.asked(Call.FLY, 2.0).granted
        assert bench.procedure.step is Step.FLIGHT
        bench.move(END)
        bench.wait(5.0)
        assert bench.procedure.step is Step.HOLD  # the plan is over
        bench.move(FIRST)
        answer = bench.asked(Call.LAND)
        assert answer == Reply(granted=True, reason="on the ground: cf1 at 0.00 m, cf2 at 0.00 m; disarmed")
        assert bench.acts == [
            Act.WAIT, Act.ARM, Act.TAKE_OFF, Act.GLIDE, Act.STREAM, Act.START, Act.GLIDE, Act.STOP_STREAM,
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


BAD: list[tuple[dict[str, object], str]] = [
    ({"reports": (WELL, VehicleReport("cf2", connected=False))}, "cf2 offline"),
    ({"reports": (WELL, replace(WELL, name="cf2", locked=True))}, "cf2 is locked: restart it"),
    ({"reports": (WELL, replace(WELL, name="cf2", volt=3.41))}, r"cf2 has 3\.41 V: 3\.60 V is the least"),
    ({"reports": (WELL, replace(WELL, name="cf2", volt=np.nan))}, "cf2 does not report its battery"),
    ({"reports": (WELL, replace(WELL, name="cf2", wrong="stabilizer.controller is 1, 2 is asked"))},
     "cf2: stabilizer.controller is 1, 2 is asked"),
    ({"reports": (WELL, replace(WELL, name="cf2", onboard=(0.0, 1.0, 0.25)))},
     r"cf2 estimates itself 0\.25 m from its measured position"),
    ({"reports": (WELL, replace(WELL, name="cf2", hover_ratio=0.73))},
     r"cf2 would be sent 73 % of the thrust at which it hovers: within 15 %"),
    ({"pos": HOME + up(0.3)}, r"cf1 is 0\.30 m above the ground"),
    ({"vel": np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])}, r"cf2 moves at 0\.20 m/s"),
    ({"pos": HOME * 0.2}, r"cf1 and cf2 are 0\.20 m apart: 0\.30 m is the least"),
    ({"pos": HOME + np.array([0.0, 0.4, 0.0])}, r"cf1 is 0\.40 m from its first point: 0\.30 m"),
    ({"plan": None}, "no plan is waiting"),
    ({"plan": replace(PLAN, names=("cf1", "cf9"))}, "the plan is for cf1, cf9, the vehicles are cf1, cf2"),
    ({"plan": replace(PLAN, high=END + np.array([0.0, 3.0, 0.0]))}, r"cf2 would fly y from 1\.00 to 4\.00 m"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "log"), BAD, ids=[log for _, log in BAD])
def test_take_off_is_refused_with_vehicle_and_number_and_nobody_arms(
    given: dict[str, object], log: str
) -> None:
    bench = _Bench()
    for name, value in given.items():
        setattr(bench, name, value)
    answer = bench.asked(Call.TAKE_OFF)
    assert not answer.granted
    assert re.search(log, answer.reason), answer.reason
    assert bench.sent == []


def test_an_old_state_refuses_the_take_off() -> None:
    bench = _Bench(blind=True)
    bench.wait(0.3)
    assert "cf1 has no state younger than 0.1 s (its last is 0.32 s old)" in bench.asked(Call.TAKE_OFF).reason


def test_vehicles_that_do_not_arm_are_disarmed_again_and_named() -> None:
    bench = _Bench(refuses={Act.ARM: "cf2 did not arm within 2 s"})
    answer = bench.asked(Call.TAKE_OFF)
    assert answer == Reply(granted=False, reason="cf2 did not arm within 2 s")
    assert bench.acts == [Act.WAIT, Act.ARM, Act.DISARM]
    assert bench.procedure.step is Step.CHECKED


def test_a_take_off_that_does_not_arrive_is_landed_and_says_where_the_vehicle_is() -> None:
    bench = _Bench(stuck={Act.TAKE_OFF})
    answer = bench.asked(Call.TAKE_OFF, 9.0)
    assert "take-off failed: cf1 is at 0.00 m, 0.50 m from where it should be; landing" in answer.reason
    assert bench.acts[-3:] == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_vehicles_are_landed_before_they_are_disarmed_where_a_take_off_is_told_to_have_failed() -> None:
    bench = _Bench(refuses={Act.TAKE_OFF: "no answer from all/takeoff"})
    bench.call(Call.TAKE_OFF)
    while Act.TAKE_OFF not in bench.acts:
        bench.wait(STEP)
    bench.move(HOME + up(0.5))
    bench.wait(8.0)
    assert bench.answer() == Reply(granted=False, reason="no answer from all/takeoff; landing")
    assert bench.acts[-3:] == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_a_landing_is_confirmed_only_on_the_ground() -> None:
    bench = up_to(Step.HOLD, stuck={Act.LAND})
    answer = bench.asked(Call.LAND, 12.0)
    assert not answer.granted
    assert "not on the ground: cf1 is at 1.00 m" in answer.reason
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
    again.move(again.pos * [1.0, 1.0, 0.0])
    again.wait(8.0)
    assert again.answer().granted


def test_a_server_that_does_not_stop_setpoints_keeps_the_vehicles_flying_them() -> None:
    bench = up_to(Step.HOLD, refuses={Act.STOP_STREAM: "all/notify_setpoints_stop does not answer"})
    answer = bench.asked(Call.LAND)
    assert not answer.granted
    assert "call land again, or emergency" in answer.reason
    assert bench.procedure.accepts(bench.setpoint_pos)
    assert bench.acts == [Act.GLIDE, Act.STOP_STREAM]


def test_setpoints_are_flown_only_from_the_hand_over_to_the_landing() -> None:
    bench = _Bench()
    assert not bench.procedure.accepts(bench.setpoint_pos)
    bench.asked(Call.TAKE_OFF)
    assert not bench.procedure.accepts(bench.setpoint_pos)
    bench.asked(Call.FLY, 2.0)
    assert bench.procedure.accepts(bench.setpoint_pos)
    bench.call(Call.LAND)
    assert not bench.procedure.accepts(bench.setpoint_pos)


def test_a_glide_that_cannot_be_certified_leaves_the_vehicles_hovering() -> None:
    words = "cf1 and cf2 would come 0.15 m into each other's zone at 1.2 s"
    bench = up_to(Step.HOVER, refuses={Act.GLIDE: words})
    assert bench.asked(Call.FLY) == Reply(granted=False, reason=words)
    assert bench.procedure.step is Step.HOVER
    assert not bench.procedure.accepts(bench.setpoint_pos)


def test_setpoints_far_from_the_vehicles_are_not_taken_over() -> None:
    bench = up_to(Step.HOVER, stuck={Act.GLIDE})
    bench.setpoint_pos = FIRST + up(0.9)  # trajectory plays something of its own
    answer = bench.asked(Call.FLY)
    assert "cf1 is 1.40 m from its setpoint" in answer.reason
    assert bench.procedure.step is Step.HOVER
    assert bench.acts == [Act.GLIDE]


def test_a_setpoint_that_jumps_in_flight_is_not_flown_and_all_land() -> None:
    bench = up_to(Step.FLIGHT)
    bench.setpoint_pos = bench.setpoint_pos + up(0.9)
    assert not bench.procedure.accepts(bench.setpoint_pos)
    bench.wait(6.0)
    assert any("a setpoint jumped by 0.90 m" in line for line in bench.log)
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_setpoints_that_stay_away_land_all() -> None:
    bench = up_to(Step.FLIGHT)
    bench.ignore_signals = True
    bench.wait(8.0)
    assert bench.acts == [Act.STOP_STREAM, Act.LAND, Act.DISARM]
    assert any("no setpoint for 2.0" in line for line in bench.log)


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
    assert bench.acts == [Act.CUT]
    assert not bench.procedure.accepts(bench.setpoint_pos)
    bench.reports = tuple(replace(one, locked=True) for one in bench.reports)
    bench.move(HOME)
    bench.wait(10.0)
    refusal = bench.asked(Call.TAKE_OFF)
    assert "the step is stopped" in refusal.reason
    bench.reports = tuple(replace(one, locked=False) for one in bench.reports)
    bench.wait(6.0)
    assert bench.asked(Call.TAKE_OFF).granted


def test_a_plan_is_flown_again_from_the_hold_by_a_new_glide() -> None:
    bench = up_to(Step.HOLD)
    assert bench.asked(Call.FLY, 3.0).granted
    assert bench.acts == [Act.GLIDE, Act.START]  # setpoints are streamed all the while


def test_vehicles_that_overlap_glide_apart_before_they_land() -> None:
    bench = up_to(Step.HOLD)
    bench.move(np.array([[0.0, 0.0, 1.0], [0.0, 0.1, 1.5]]))
    bench.call(Call.LAND)
    bench.wait(STEP)
    assert bench.acts == [Act.GLIDE]
    bench.move(FIRST)
    bench.wait(6.0)
    assert bench.answer().granted
    assert bench.acts == [Act.GLIDE, Act.STOP_STREAM, Act.LAND, Act.DISARM]


def test_vehicles_that_land_by_themselves_are_watched_to_the_ground() -> None:
    bench = up_to(Step.FLIGHT)
    bench.reports = tuple(replace(one, flies=False) for one in bench.reports)
    bench.wait(STEP)
    assert bench.procedure.step is Step.LANDING
    bench.move(HOME)
    bench.wait(2.0)
    assert bench.acts == [Act.DISARM]


def test_a_start_joins_setpoints_at_the_vehicles_and_none_that_are_far() -> None:
    """The plan runs already: vehicles on the ground would jump to where it is."""
    bench = _Bench()
    bench.setpoint_pos = np.array([[1.8, 0.0, 0.7], [0.7, 1.0, 1.9]])
    refusal = bench.asked(Call.START)
    assert "cf1 is 1.93 m from its setpoint: 0.30 m is the most; call take_off, then fly" in refusal.reason
    assert bench.sent == []
    bench.setpoint_pos = HOME.copy()
    bench.stuck = {Act.STREAM}
    assert bench.asked(Call.START, 1.0).granted
    assert bench.acts == [Act.ARM, Act.STREAM]


def test_a_dry_run_sends_nothing_and_says_what_would_be_sent() -> None:
    bench = _Bench(params=FlightProcedureParams(dry_run=True))
    answer = bench.asked(Call.TAKE_OFF)
    assert answer.granted
    assert (
        "not checked: own estimate of cf1, cf2; take_off means: let the reference rest at the vehicles, then"
        in answer.reason
    )
    assert answer.reason.endswith("then take off to 0.50 m in 2.0 s")
    assert bench.asked(Call.LAND).reason.startswith("dry run, nothing is sent; the step is checked")
    assert bench.sent == []
    assert bench.procedure.step is Step.CHECKED


def test_a_room_without_an_inside_is_refused() -> None:
    with pytest.raises(ValueError, match="lowest x, y, z and highest x, y, z"):
        FlightProcedureParams(room=(0.0, 0.0, 0.0, 1.0, 1.0, 0.0))


def test_a_vehicle_measured_just_below_the_floor_is_at_0_m() -> None:
    observation = replace(_Bench().observe(), pos=HOME + up(-0.001))
    assert places(observation) == "cf1 at 0.00 m, cf2 at 0.00 m"
