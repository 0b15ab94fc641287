"""Vehicles that do at once what a flight procedure tells them, for its tests."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from q2q_control.flight_procedure.observation import Observation, PlanOutline, VehicleReport
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.procedure import FlightProcedure
from q2q_control.flight_procedure.steps import Act, Call, Order, Step
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Array, Names

NAMES = ("cf1", "cf2")
GROUND = -0.8
ROOM = (-1.0, -2.0, -1.5, 3.5, 3.0, 2.5)
HOME = np.array([[2.0, -1.0, GROUND], [1.4, 0.2, GROUND]])
FIRST = HOME + np.array([0.0, 0.0, 1.0])
END = FIRST + np.array([1.0, 0.0, 0.0])
PLAN = PlanOutline(NAMES, FIRST, FIRST, END, duration=4.0)
WELL = VehicleReport(
    "cf1", connected=True, volt=4.0, armed=True, locked=False, wrong="", onboard=None, hover_ratio=1.0
)
STEP = 0.02
PARAMS = FlightProcedureParams(ground_height=GROUND, room=ROOM)
LANDING = LandingParams()


def up(metres: float) -> Array:
    return np.array([0.0, 0.0, metres])


def at_height(pos: Array, height: float) -> Array:
    """Return positions (n, 3) at another height [m]."""
    return np.column_stack([pos[:, :2], np.full(len(pos), height)])


@dataclass
class Bench:
    """Vehicles that do at once what they are told, unless `stuck`, and the procedure that tells them."""

    params: FlightProcedureParams = PARAMS
    landing: LandingParams = LANDING
    t: float = 100.0
    pos: Array = field(default_factory=HOME.copy)
    vel: Array = field(default_factory=lambda: np.zeros((2, 3)))
    setpoint_pos: Array = field(default_factory=HOME.copy)
    setpoint_vel: Array = field(default_factory=lambda: np.zeros((2, 3)))
    seen_at: float = 100.0
    heard_at: float = 100.0
    unmeasured: bool = False
    ignore_signals: bool = False
    reports: tuple[VehicleReport, ...] = (WELL, replace(WELL, name="cf2"))
    plan: PlanOutline | None = PLAN
    cut: Names = ()
    without_attitude: Names = ()
    refuses: dict[Act, str] = field(default_factory=dict)
    stuck: set[Act] = field(default_factory=set)
    sent: list[Order] = field(default_factory=list)
    replies: list[tuple[Call, Reply]] = field(default_factory=list)
    log: list[str] = field(default_factory=list)
    outcome: Reply | None = None

    def __post_init__(self) -> None:
        """Begin with vehicles on the ground, and a tick."""
        self.procedure = FlightProcedure(self.params, self.landing)
        self.wait(STEP)

    def observe(self) -> Observation:
        """Return what the procedure sees now."""
        return Observation(
            self.reports, self.pos, self.vel, np.full(2, self.t - self.seen_at), self.setpoint_pos,
            self.setpoint_vel, self.t - self.heard_at, self.plan, self.cut, self.without_attitude,
        )  # fmt: skip

    def call(self, call: Call) -> Reply | None:
        """Return the reply to a call, None if it comes later."""
        return self.procedure.call(call, self.observe(), self.t)

    def wait(self, seconds: float) -> None:
        """Let time pass and carry out what is ordered."""
        for _ in range(round(seconds / STEP)):
            self.t += STEP
            self.seen_at = self.seen_at if self.unmeasured else self.t
            if not self.ignore_signals:
                self.heard_at = self.t
                self.procedure.take_setpoint(self.setpoint_pos)
            self.procedure.update(self.observe(), self.outcome, self.t)
            self.outcome = None
            for order in self.procedure.state.take_orders():
                self._obey(order)
            self.replies += self.procedure.state.take_replies()
            self.log += self.procedure.state.take_log()

    def streams(self) -> bool:
        """Return whether the setpoints are flown now."""
        self.procedure.take_setpoint(self.setpoint_pos)
        return self.procedure.streams

    def answer(self) -> Reply:
        """Return the one reply that came."""
        assert len(self.replies) == 1, self.replies
        return self.replies.pop()[1]

    def asked(self, call: Call, seconds: float = 8.0) -> Reply:
        """Call, let time pass, and return the answer."""
        at_once = self.call(call)
        self.wait(seconds if at_once is None else STEP)
        return self.answer() if at_once is None else at_once

    @property
    def acts(self) -> list[Act]:
        """Return what was ordered, in order."""
        return [order.act for order in self.sent]

    def _obey(self, order: Order) -> None:
        self.sent.append(order)
        self.outcome = Reply(order.act not in self.refuses, self.refuses.get(order.act, ""))
        if order.act in self.stuck or order.act in self.refuses:
            return
        moves: dict[Act, Callable[[], None]] = {
            Act.TAKE_OFF: lambda: self.move(at_height(self.pos, order.height)),
            Act.TRANSIT: lambda: self.move(FIRST if self.procedure.step is Step.HOLD else self.pos),
            Act.STREAM: lambda: self.move(FIRST),
            Act.START: lambda: None,
            Act.LAND: lambda: self.move(at_height(self.pos, order.height)),
        }
        moves.get(order.act, lambda: None)()

    def move(self, pos: Array) -> None:
        """Move vehicles and setpoints somewhere, within what a setpoint may move in a tick."""
        for share in np.linspace(0.0, 1.0, 50):
            self.procedure.take_setpoint(self.setpoint_pos + share * (pos - self.setpoint_pos))
        self.pos, self.setpoint_pos = pos.copy(), pos.copy()


def up_to(step: Step, **given: object) -> Bench:
    """Return a bench whose procedure has come to a step."""
    bench = Bench(**given)
    road = {Step.HOVER: [Call.TAKE_OFF], Step.FLIGHT: [Call.TAKE_OFF, Call.FLY],
            Step.HOLD: [Call.TAKE_OFF, Call.FLY, Call.HOLD]}  # fmt: skip
    for call in road.get(step, []):
        assert bench.asked(call, 3.0).granted
    assert bench.procedure.step is step
    bench.sent.clear()
    return bench
