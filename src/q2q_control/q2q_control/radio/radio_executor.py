"""Let a radio pilot carry out the flight procedure's orders, and report its vehicles."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Order
from q2q_control.radio.link import VehicleLink
from q2q_control.radio.radio_pilot import Phase, RadioPilot
from q2q_model.node.reply import Reply
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.hover_thrust import hover_ratio


@dataclass(frozen=True, slots=True)
class RadioExecutor:
    """Pilot and links as the procedure's crew."""

    pilot: RadioPilot
    links: Mapping[str, VehicleLink]
    vehicle: Vehicle
    """What newtons are turned into PWM for."""

    def begin(self, order: Order, t: float) -> None:
        """Begin to carry out an order at time t [s]."""
        self.pilot.begin(order, t)

    def outcome(self, t: float) -> Reply | None:
        """Return what became of the last order by time t [s], once; None while that is not known."""
        return self.pilot.outcome(t)

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return what every vehicle says of itself."""
        return tuple(self._report(name, link) for name, link in self.links.items())

    def _report(self, name: str, link: VehicleLink) -> VehicleReport:
        health = link.health()
        return VehicleReport(
            name=name,
            connected=health.connected,
            volt=health.volt,
            armed=health.armed,
            locked=health.locked,
            flies=self.pilot.phases[name] is Phase.FLYING,
            wrong=health.wrong,
            onboard=health.onboard,
            hover_ratio=nan if health.own_hover is None else hover_ratio(self.vehicle, health.own_hover),
        )
