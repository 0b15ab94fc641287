"""Interface of an executor of the procedure's orders: a radio pilot, or Crazyswarm2's server."""

from typing import Protocol

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Order
from q2q_model.node.reply import Reply


class OrderExecutor(Protocol):
    """Executor of orders."""

    def begin(self, order: Order, t: float) -> None:
        """Start executing an order at time t [s]."""

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order by time t [s], once; None while it is unknown."""

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle."""
