"""Vehicles of the node `radio`: their links, the pilot, and what each tick sends."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack

from q2q_control.flight_procedure.flown_ticks import FlownTick, FlownTicks
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.radio.crazyflies_file import Crazyflie, crazyflies_at, crazyflies_from_file
from q2q_control.radio.link.cflib_link import CflibLink
from q2q_control.radio.link.firmware_params import firmware_params, left_out_lines, settings_lines
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.radio.link.setpoints import cut_vehicles, full_states, level_rpyt, rpyt_setpoints
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.radio_pilot import RadioPilot
from q2q_control.radio.radio_executor import RadioExecutor
from q2q_control.radio.radio_params import RadioNodeParams
from q2q_model.diagnostics.health import Health
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Names, SwarmState
from q2q_model.vehicle.constants import vehicle_by_name

WATCH_S = 0.02
"""Period of checking links and batteries [s]."""
SETTLE_S = 0.5
"""Time from the end of a landing's polynomial to rest on the ground [s]."""


class RadioVehicles:
    """Links to vehicles and the pilot that flies them."""

    def __init__(
        self,
        params: RadioNodeParams,
        limits: RadioPilotParams,
        procedure: tuple[FlightProcedureParams, LandingParams],
        health: Health,
    ) -> None:
        """Open the links; vehicles land as in the procedure; `health` counts ticks.

        Raises:
            ValueError: no vehicles, a wrong file or parameter, cflib is missing, a URI is open elsewhere.
            OSError: a file cannot be read.
        """
        self._sends_poses = params.places
        vehicle = vehicle_by_name(params.vehicle, params.firmware)
        self._scale = RpytScale(vehicle.full_pwm_thrust)
        crazyflies = _crazyflies(params)
        self.firmware_params = {
            one.name: firmware_params(
                params.firmware_params, params.mode, poses=params.places, of_file=one.firmware_params
            )
            for one in crazyflies
        }
        """Parameters that are set on each vehicle once it is connected."""
        of_files = {one.name: one.firmware_params for one in crazyflies}
        self.settings = settings_lines(self.firmware_params) + left_out_lines(of_files, self.firmware_params)
        """Lines for the log on these parameters."""
        flight, landing = procedure
        self.links = _open_links(crazyflies, self.firmware_params, params.toc_cache, dry_run=flight.dry_run)
        hover = level_rpyt(vehicle.hover_thrust, self._scale) if params.mode == "command" else None
        self.pilot = RadioPilot(self.links, limits, hover, landing, flight.ground_height)
        self.executor = RadioExecutor(self.pilot, self.links, vehicle)
        self.ticks = FlownTicks(params.mode, health, aware=params.aware)

    @property
    def names(self) -> Names:
        """Return the names of the vehicles."""
        return tuple(self.links)

    def take(self, topic: str, stamp_ns: int, value: Signal, now: float) -> None:
        """Take a signal at time now [s]; send its pose, or the tick that it completes."""
        tick = self.ticks.take(topic, stamp_ns, value)
        if isinstance(value, SwarmState):
            self.pilot.update_state(value, now, send=self._sends_poses)
        if tick is not None:
            self._send(tick, now)

    def watch(self, now: float) -> list[str]:
        """Check links and batteries at time now [s]; return lines for the log."""
        self.pilot.watch(now)
        for link in self.links.values():
            link.keep_open()
        from_links = [f"{name}: {line}" for name, link in self.links.items() for line in link.log_lines()]
        return [*from_links, *self.pilot.log_lines()]

    def phases(self) -> dict[str, str]:
        """Return the phase of every vehicle for diagnostics."""
        return {f"phase_{name}": phase.value for name, phase in self.pilot.phases.items()}

    def land(self, now: float) -> float:
        """Land flying vehicles at time now [s]; return the time until all are down [s], 0 if none flies."""
        return self.pilot.landing_left(now) + SETTLE_S if self.pilot.land(now) else 0.0

    def close(self) -> None:
        """Close the links: cflib's last packet stops the motors, except in a dry run."""
        for link in self.links.values():
            link.close()

    def _send(self, tick: FlownTick, now: float) -> None:
        if tick.command is not None:
            self.pilot.cut(cut_vehicles(tick.command), now)
            if tick.flown:
                self.pilot.fly_rpyt(tick.command.names, rpyt_setpoints(tick.command, self._scale), now)
        elif tick.setpoint is not None and tick.flown:
            self.pilot.fly_full_states(tick.setpoint.names, full_states(tick.setpoint, tick.downwash), now)


def _open_links(
    crazyflies: Sequence[Crazyflie], firmware: Mapping[str, Mapping[str, float]], cache: str, *, dry_run: bool
) -> dict[str, CflibLink]:
    """Open all links, or none: if one is refused, those before it are closed."""
    links: dict[str, CflibLink] = {}
    with ExitStack() as opened:
        for one in crazyflies:
            links[one.name] = CflibLink(one.name, one.uri, firmware[one.name], cache, dry_run=dry_run)
            opened.callback(links[one.name].close)
        opened.pop_all()
    return links


def _crazyflies(params: RadioNodeParams) -> tuple[Crazyflie, ...]:
    if params.crazyflies:
        return crazyflies_from_file(params.crazyflies)
    return crazyflies_at(params.vehicles, params.uris)
