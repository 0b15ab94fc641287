"""Say what carries out the procedure's orders: a radio pilot, or Crazyswarm2's server."""

from typing import Protocol

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Order
from q2q_model.node.reply import Reply


class OrderExecutor(Protocol):
    """What reaches the vehicles."""

    def begin(self, order: Order, t: float) -> None:
        """Begin to carry out an order at time t [s]."""

    def outcome(self, t: float) -> Reply | None:
        """Return what became of the last order by time t [s], once; None while that is not known."""

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return what every vehicle says of itself."""
