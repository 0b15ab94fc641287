"""Pilot of one vehicle over its radio link, which also lands it or cuts its motors by itself.

    OFFLINE <-> READY -- arm --> ARMING --> ARMED -- take off --> CLIMBING -- stream --> FLYING
                  ^                           |                      |                     |
                  +---------- disarm ---------+------ LANDING <------+--- land ------------+

| event | what happens |
|---|---|
| armed | a zero RPYT setpoint unlocks the thrust |
| arming takes longer than arm_s | back to READY |
| flying | the command of every tick is sent; before that, none |
| link lost in flight | nothing is sent; the firmware levels after 0.5 s and cuts after 2 s |
| lost while climbing or landing | the high-level commander goes on; land and cut are sent all the same |
| back, and its supervisor says that it flies | CLIMBING goes on; from FLYING, or if ordered to, it lands |
| battery below voltage_land for voltage_land_s | the vehicle lands by itself, whatever is commanded |
| cut, and not locked | the cut is sent again, for 2 s of connection, also after the link was lost |
| no command for command_timeout_level_s | RPYT: level at hover thrust; full states: hover at the last one |
| none for command_timeout_land_s | the vehicle lands by itself |
| the same, with RPYT and no fresh state | it descends level, at the failsafe's land_share of hover |
| the same for command_timeout_stop_s | its motors are cut and locked |

The last four rows keep the firmware's watchdog fed while the radio works and the controller does not; they
start after the first command in flight, and end with the next command before the landing.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import ZERO_RPYT, FullState, RpytSetpoint
from q2q_control.radio.link.vehicle_link import LinkHealth, VehicleLink
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.vehicle_record import AIRBORNE, ON_BOARD, Phase, VehicleRecord

OBEYED_IN = {
    Act.ARM: frozenset({Phase.READY}),
    Act.TAKE_OFF: frozenset({Phase.ARMED}),
    Act.STREAM: frozenset({Phase.ARMED, Phase.CLIMBING}),
    Act.DISARM: frozenset({Phase.ARMING, Phase.ARMED, Phase.LANDING, Phase.READY}),
}
"""Phases in which a vehicle carries out an order."""


@dataclass(frozen=True, slots=True)
class PilotSetup:
    """Limits, landing and setpoints of a VehiclePilot."""

    params: RadioPilotParams
    landing: LandingParams
    ground_height: float
    """Height at which it lands [m], world."""
    hover: RpytSetpoint | None
    """Level RPYT setpoint; None: it is flown by full states."""


class VehiclePilot:
    """Pilot of one vehicle, with the record of its phase."""

    def __init__(self, name: str, link: VehicleLink, setup: PilotSetup, log: Callable[[str], None]) -> None:
        """Fly the vehicle of a link; `log` takes log lines."""
        self._name, self._link, self._log = name, link, log
        self._params, self._landing, self._ground_height = setup.params, setup.landing, setup.ground_height
        self._hover = setup.hover
        self._record = VehicleRecord()

    @property
    def phase(self) -> Phase:
        """Return its phase."""
        return self._record.phase

    @property
    def air_phase(self) -> Phase:
        """Return its phase; of a vehicle lost in the air the one on board."""
        return self._record.air_phase

    @property
    def motors_cut(self) -> bool:
        """Return whether its motors were cut since it was armed."""
        return bool(np.isfinite(self._record.cut_at))

    @property
    def stopping(self) -> bool:
        """Return whether it is connected and its cut is still sent again."""
        return self.phase is not Phase.OFFLINE and self._record.cut_left > 0.0

    @property
    def landing_end(self) -> float:
        """Return when its last landing ends or has ended [s]."""
        return self._record.since + self._record.landing_s

    @property
    def armed(self) -> bool:
        """Return whether its supervisor reports it as armed."""
        return self._link.health().armed

    def carry_out(self, order: Order, t: float) -> None:
        """Begin an order given at time t [s], if it is one to its phase (OBEYED_IN)."""
        if self.phase not in OBEYED_IN.get(order.act, frozenset()):
            return
        if order.act is Act.ARM:
            self._enter(Phase.ARMING, t)
            self._record.arm()
            self._link.arm()
        elif order.act is Act.TAKE_OFF:
            self._link.take_off(order.height, order.duration)
            self._enter(Phase.CLIMBING, t)
        elif order.act is Act.STREAM:
            self._enter(Phase.FLYING, t)
        elif order.act is Act.DISARM:
            self._link.disarm()
            self._enter(Phase.READY, t)

    def land(self, t: float) -> None:
        """Command the onboard landing at time t [s]."""
        self._record.landing_s = self._landing.duration(self._record.height - self._ground_height)
        self._link.land(self._ground_height, self._record.landing_s)
        self._enter(Phase.LANDING, t)

    def cut(self, t: float) -> None:
        """Cut and lock its motors at time t [s]."""
        self._record.cut(t)
        self._link.cut()
        if self.phase is not Phase.OFFLINE:
            self._enter(Phase.READY, t)

    def measured(self, height: float, t: float) -> None:
        """Note its measured height [m], received at time t [s]."""
        self._record.measured_at, self._record.height = t, height

    def send_pose(self, pos: Sequence[float], quat: Sequence[float] | None) -> None:
        """Send an external pose, or a position alone, if it is connected."""
        if self.phase is not Phase.OFFLINE:
            self._link.send_external_pose(pos, quat)

    def fly_rpyt(self, setpoint: RpytSetpoint, t: float) -> None:
        """Send an RPYT setpoint, received at time t [s], if it flies."""
        if self.phase is Phase.FLYING:
            self._record.commanded_at = t
            self._link.send_rpyt(setpoint)

    def fly_full_state(self, full_state: FullState, t: float) -> None:
        """Send a full state, received at time t [s], if it flies."""
        if self.phase is Phase.FLYING:
            self._record.commanded_at, self._record.full_state = t, full_state
            self._link.send_full_state(full_state)

    def watch(self, t: float) -> None:
        """Check link, battery and missing commands at time t [s]."""
        self._watch_link(self._link.health(), t)
        if self.phase is Phase.FLYING:
            self._watch_silence(t)

    def _watch_link(self, health: LinkHealth, t: float) -> None:
        one = self._record
        if not health.connected:
            if one.phase is not Phase.OFFLINE:
                self._enter(Phase.OFFLINE, t)
            return
        if one.poll_cut(t, locked=health.locked):
            self._link.cut()  # the first may be lost on the way, or the link was down
        if one.phase is Phase.OFFLINE:
            self._resume(health, t)
        elif one.phase is Phase.ARMING:
            self._watch_arming(health, t)
        elif one.phase in {Phase.CLIMBING, Phase.FLYING}:
            self._watch_flight(health, t)
        elif one.phase is Phase.LANDING and t - one.since > one.landing_s:
            self._enter(Phase.READY, t)

    def _resume(self, health: LinkHealth, t: float) -> None:
        """Resume its phase, connected again, once it says whether it flies."""
        one = self._record
        if one.lost is None or health.flying is False or health.locked:
            self._enter(Phase.READY, t)
        elif health.flying and one.lost is Phase.CLIMBING:
            self._enter(Phase.CLIMBING, t)
        elif health.flying:
            one.phase, one.lost = one.lost, None
            self.land(t)

    def _watch_arming(self, health: LinkHealth, t: float) -> None:
        if health.armed:
            if self._hover is not None:
                self._link.send_rpyt(ZERO_RPYT)
            self._enter(Phase.ARMED, t)
        elif t - self._record.since > self._params.arm_s:
            self._enter(Phase.READY, t)

    def _watch_flight(self, health: LinkHealth, t: float) -> None:
        if health.locked:
            self._enter(Phase.READY, t)
            self._log(f"{self._name} is locked and must be restarted")
            return
        one = self._record
        one.low_since = min(one.low_since, t) if health.volt < self._params.voltage_land else np.inf
        if t - one.low_since >= self._params.voltage_land_s:
            self._log(f"{self._name} has {health.volt:.2f} V and lands")
            self.land(t)

    def _watch_silence(self, t: float) -> None:
        silent, limits = t - self._record.commanded_at, self._params
        if silent < limits.command_timeout_level_s or not np.isfinite(silent):
            return
        if silent < limits.command_timeout_land_s:
            self._hold()
        elif self._hover is None or t - self._record.measured_at <= self._landing.stale_s:
            self._log(f"{self._name} has no command for {limits.command_timeout_land_s} s and lands")
            self.land(t)
        elif silent < limits.command_timeout_stop_s:
            share = FallbackParams().land_share
            self._link.send_rpyt(replace(self._hover, pwm=round(share * self._hover.pwm)))
        else:
            self._log(
                f"{self._name} has no command for {limits.command_timeout_stop_s} s and has descended "
                "without measurements"
            )
            self.cut(t)

    def _hold(self) -> None:
        """Send a setpoint that keeps it in place."""
        if self._hover is not None:
            self._link.send_rpyt(self._hover)
        elif self._record.full_state is not None:
            zero = (0.0, 0.0, 0.0)
            self._link.send_full_state(replace(self._record.full_state, vel=zero, acc=zero, ang_vel=zero))

    def _enter(self, phase: Phase, t: float) -> None:
        before = self.phase
        if before in AIRBORNE and phase is Phase.OFFLINE:
            self._log(f"{self._name} is lost in flight: {ON_BOARD[before]}")
        elif before is not phase:
            self._log(f"{self._name} is {phase.value}")
        self._record.enter(phase, t)
