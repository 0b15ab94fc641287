"""State of the flight procedure: its step, pending call and order, and what it has to send."""

from math import inf

from q2q_control.flight_procedure.checks.arrival import Arrival
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Call, Order, Step
from q2q_model.node.reply import Reply


class ProcedureState:
    """Step of a flight, its pending call and order, and queues of orders, replies and log lines."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._step_timeout_s = params.step_timeout_s
        self.step = Step.OFFLINE
        self.since = -inf
        """Time at which the step began [s]."""
        self._moving_at = -inf
        self.arrival = Arrival(params, landing)
        """Which vehicles are at rest where the step sends them."""
        self.restarted = SettleTimer(params.settle_s)
        """Whether vehicles have been restarted for long enough."""
        self.pending: Call | None = None
        """Call that is not answered yet."""
        self.waiting: Order | None = None
        """Order whose outcome is unknown."""
        self._ordered = -inf
        self._orders: list[Order] = []
        self._replies: list[tuple[Call, Reply]] = []
        self.log: list[str] = []

    def enter(self, step: Step, t: float, why: str = "") -> None:
        """Enter a step at time t [s]."""
        self.step, self.since, self._moving_at = step, t, t
        self._restart_timers()
        self.log.append(f"step {step.value}{': ' if why else ''}{why}")

    def give(self, order: Order, t: float) -> None:
        """Give an order at time t [s]."""
        self.waiting, self._ordered = order, t
        self._orders.append(order)
        self._restart_timers()

    def answer(self, *, granted: bool, reason: str) -> None:
        """Answer the pending call, if there is one."""
        if self.pending is not None:
            self.log.append(f"{self.pending.value}: {reason}")
            self._replies.append((self.pending, Reply(granted=granted, reason=reason)))
        self.pending = None

    def moving(self, t: float) -> None:
        """Take note that setpoints move at time t [s]: the step is under way."""
        self._moving_at = t

    def late(self, duration: float, t: float) -> bool:
        """Return whether a step of this duration [s] has failed by time t [s]."""
        return t - max(self.since, self._moving_at) > duration + self._step_timeout_s

    def overdue(self, order: Order, t: float) -> Reply | None:
        """Return the failure of an order without outcome; None while it may still come."""
        if t - self._ordered <= self._step_timeout_s:
            return None
        return Reply(granted=False, reason=f"{order}: no answer in {self._step_timeout_s:g} s")

    def take_orders(self) -> tuple[Order, ...]:
        """Return and clear the orders to execute."""
        orders, self._orders = tuple(self._orders), []
        return orders

    def take_replies(self) -> list[tuple[Call, Reply]]:
        """Return and clear the answers to pending calls."""
        replies, self._replies = self._replies, []
        return replies

    def take_log(self) -> list[str]:
        """Return and clear the log lines."""
        lines, self.log = self.log, []
        return lines

    def _restart_timers(self) -> None:
        self.arrival.reset()
        self.restarted.reset()


class SettleTimer:
    """Time since which a condition holds."""

    def __init__(self, settle_s: float) -> None:
        """Call a condition settled once it has held for settle_s [s]."""
        self._settle_s = settle_s
        self._since = inf

    def update(self, holds: bool, t: float) -> bool:
        """Return whether the condition, which holds at t [s] or not, is settled."""
        self._since = min(self._since, t) if holds else inf
        return t - self._since >= self._settle_s

    def reset(self) -> None:
        """Start again."""
        self._since = inf
