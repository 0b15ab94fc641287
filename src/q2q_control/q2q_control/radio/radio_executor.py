"""Executor of the flight procedure's orders over the radio."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.steps import Order
from q2q_control.radio.link.vehicle_link import VehicleLink
from q2q_control.radio.pilot.radio_pilot import RadioPilot
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_model.node.reply import Reply
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.hover_thrust import hover_ratio


@dataclass(frozen=True, slots=True)
class RadioExecutor:
    """Pilot and links, as the procedure's executor."""

    pilot: RadioPilot
    links: Mapping[str, VehicleLink]
    vehicle: Vehicle
    """Constants that convert newtons to PWM."""

    def begin(self, order: Order, t: float) -> None:
        """Start executing an order at time t [s]."""
        self.pilot.begin(order, t)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order by time t [s], once; None while it is unknown."""
        return self.pilot.outcome(t)

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle."""
        return tuple(self._report(name, link) for name, link in self.links.items())

    def _report(self, name: str, link: VehicleLink) -> VehicleReport:
        health = link.health()
        return VehicleReport(
            name=name,
            connected=health.connected,
            volt=health.volt,
            armed=health.armed,
            locked=health.locked,
            airborne=self.pilot.phases[name] in {Phase.CLIMBING, Phase.FLYING} and health.flying is not False,
            flies=self.pilot.phases[name] is Phase.FLYING,
            cut=name in self.pilot.motors_cut,
            wrong=health.wrong,
            onboard=health.onboard,
            hover_ratio=nan if health.own_hover is None else hover_ratio(self.vehicle, health.own_hover),
        )
