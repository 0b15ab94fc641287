"""Pilot that executes the procedure's orders over the radio, and lands vehicles or cuts motors by itself.

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
| battery below volt_land for volt_land_s | the vehicle lands by itself, whatever is commanded |
| state older than stale_s | no pose is sent; the firmware's estimate coasts |
| command with status CUT | the vehicle's motors are cut and locked |
| cut, and not locked | the cut is sent again, for 2 s of connection, also after the link was lost |
| a command that is not finite | it is not sent, and counts as none; the other vehicles' are sent |
| no command for silent_s | RPYT: level at hover thrust; full states: hover at the last one |
| none for silent_land_s | the vehicle lands by itself |
| the same, with RPYT and no fresh state | it descends level, at the ladder's land_share of hover |
| the same for silent_stop_s | its motors are cut and locked |

The last four rows keep the firmware's watchdog fed while the radio works and the controller does not; they
start after the first command in flight, and end with the next command before the landing. The procedure
decides whether vehicles may be armed (q2q_control.flight_procedure).

A vehicle's pose is sent once per frame, and only if it was measured in that frame, moved on by
pose_delay_s (q2q_model.geometry.pose_ahead); where no attitude was ever measured, only its position is.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link import LinkHealth, VehicleLink
from q2q_control.radio.pilot_params import RadioPilotParams
from q2q_control.radio.setpoints import ZERO_RPYT, FullState, RpytSetpoint
from q2q_control.radio.vehicle_record import AIRBORNE, ON_BOARD, Phase, VehicleRecord
from q2q_model.estimation.attitude.attitude_tracks import measured_attitudes
from q2q_model.geometry.pose_ahead import extrapolate_pose
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names, SwarmState, TrackStatus


class RadioPilot:
    """Phases of all vehicles, and the pending order."""

    def __init__(
        self,
        links: Mapping[str, VehicleLink],
        params: RadioPilotParams,
        hover: RpytSetpoint | None,
        landing: LandingParams | None = None,
        ground: float = 0.0,
    ) -> None:
        """Fly by RPYT setpoints, the level one `hover`, or by full states if None; land at `ground` [m]."""
        self._links = dict(links)
        self._params = params
        self._landing = landing or LandingParams()
        self._ground = ground
        self._order: Order | None = None
        self._ordered = -np.inf
        self._hover = hover
        self._vehicles = {name: VehicleRecord() for name in links}
        self._last_stamp = -np.inf
        self._log: list[str] = []

    @property
    def phases(self) -> dict[str, Phase]:
        """Return the phase of every vehicle."""
        return {name: one.phase for name, one in self._vehicles.items()}

    @property
    def motors_cut(self) -> frozenset[str]:
        """Return the vehicles whose motors were cut since they were armed."""
        return frozenset(name for name, one in self._vehicles.items() if np.isfinite(one.cut_at))

    def landing_left(self, t: float) -> float:
        """Return the time from t [s] until the last landing has ended [s]; 0 if none is under way."""
        landing = [one for one in self._vehicles.values() if one.air_phase is Phase.LANDING]
        return max((0.0, *(one.since + one.landing_s - t for one in landing)))

    def log_lines(self) -> list[str]:
        """Return and clear the log lines."""
        lines, self._log = self._log, []
        return lines

    def begin(self, order: Order, t: float) -> None:
        """Start executing an order at time t [s]; `outcome` returns its result."""
        self._order, self._ordered = order, t
        if order.act is Act.ARM:
            self._each({Phase.READY}, self._arm_one, t)
        elif order.act is Act.TAKE_OFF:
            for name in self._in({Phase.ARMED}):
                self._links[name].take_off(order.height, order.duration)
                self._enter(name, Phase.CLIMBING, t)
        elif order.act is Act.STREAM:
            for name in self._in({Phase.ARMED, Phase.CLIMBING}):
                self._enter(name, Phase.FLYING, t)
        elif order.act is Act.LAND:
            self.land(t)
        elif order.act is Act.DISARM:
            self._each({Phase.ARMING, Phase.ARMED, Phase.LANDING, Phase.READY}, self._disarm_one, t)
        elif order.act is Act.EMERGENCY:
            self.cut_all(t)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order by time t [s], once; None while it is unknown."""
        order = self._order
        if order is None:
            return None
        reply = self._arming_outcome() if order.act is Act.ARM else self._order_outcome(order.act, t)
        if reply is not None:
            self._order = None
        return reply

    def land(self, t: float) -> bool:
        """Land all flying vehicles by themselves; return whether any lands, from now or from before."""
        for name, one in self._vehicles.items():
            if one.air_phase in {Phase.CLIMBING, Phase.FLYING}:
                self._land(name, t)
        return any(one.air_phase is Phase.LANDING for one in self._vehicles.values())

    def cut_all(self, t: float) -> None:
        """Cut and lock all motors."""
        for name in self._links:
            self._cut_one(name, t)

    def cut(self, names: Names, t: float) -> None:
        """Cut and lock the motors of these vehicles, which are commanded CUT, if they fly."""
        for name in names:
            if name in self._vehicles and self._vehicles[name].air_phase in AIRBORNE:
                self._log.append(f"{name} is commanded CUT: motors stopped")
                self._cut_one(name, t)

    def watch(self, t: float) -> None:
        """Check links, batteries and missing commands at time t [s]."""
        for name, one in self._vehicles.items():
            self._watch(name, one, self._links[name].health(), t)
            if one.phase is Phase.FLYING:
                self._watch_silence(name, one, t)

    def update_state(self, state: SwarmState, t: float, *, send: bool = True) -> None:
        """Store a frame's state received at time t [s]; send the poses measured in it, once."""
        fresh = state.status == TrackStatus.TRACKED
        skip_sending = state.t == self._last_stamp or not send
        self._last_stamp = state.t
        pos, quat = extrapolate_pose(state, self._params.pose_delay_s)
        turned = measured_attitudes(state)
        for row, name in enumerate(state.names):
            if name not in self._vehicles or not fresh[row] or not np.isfinite(state.pos[row]).all():
                continue
            self._vehicles[name].measured_at, self._vehicles[name].height = t, float(state.pos[row, 2])
            if not skip_sending and self._vehicles[name].phase is not Phase.OFFLINE:
                attitude = quat[row].tolist() if turned[row] else None
                self._links[name].send_external_pose(pos[row].tolist(), attitude)

    def fly_rpyt(self, names: Names, rpyt_setpoints: Sequence[RpytSetpoint | None], t: float) -> None:
        """Send a tick's RPYT setpoints, received at time t [s], to the flying vehicles; None: no command."""
        for name, rpyt in zip(names, rpyt_setpoints, strict=True):
            if rpyt is not None and self._flies(name):
                self._vehicles[name].commanded_at = t
                self._links[name].send_rpyt(rpyt)

    def fly_full_states(self, names: Names, states: Sequence[FullState | None], t: float) -> None:
        """Send a tick's full states, received at time t [s], to the flying vehicles; None: no command."""
        for name, one in zip(names, states, strict=True):
            if one is not None and self._flies(name):
                self._vehicles[name].commanded_at, self._vehicles[name].full_state = t, one
                self._links[name].send_full_state(one)

    def _arming_outcome(self) -> Reply | None:
        """Return the outcome of arming; None while it goes on."""
        if self._in({Phase.ARMING}):
            return None
        missing = [name for name, one in self._vehicles.items() if one.phase is not Phase.ARMED]
        reason = f"{', '.join(missing)} did not arm within {self._params.arm_s:g} s" if missing else ""
        return Reply(granted=not missing, reason=reason)

    def _order_outcome(self, act: Act, t: float) -> Reply | None:
        if act is not Act.DISARM:
            return Reply(granted=True)
        armed = [name for name, link in self._links.items() if link.health().armed]
        if armed and t - self._ordered < self._params.arm_s:
            return None
        reason = f"{', '.join(armed)} armed again: the build arms itself" if armed else ""
        return Reply(granted=not armed, reason=reason)

    def _in(self, phases: Collection[Phase]) -> list[str]:
        return [name for name, one in self._vehicles.items() if one.phase in phases]

    def _each(self, phases: Collection[Phase], act: Callable[[str, float], None], t: float) -> None:
        for name in self._in(phases):
            act(name, t)

    def _arm_one(self, name: str, t: float) -> None:
        self._enter(name, Phase.ARMING, t)
        self._vehicles[name].arm()
        self._links[name].arm()

    def _cut_one(self, name: str, t: float) -> None:
        self._vehicles[name].cut(t)
        self._links[name].cut()
        if self._vehicles[name].phase is not Phase.OFFLINE:
            self._enter(name, Phase.READY, t)

    def _disarm_one(self, name: str, t: float) -> None:
        self._links[name].disarm()
        self._enter(name, Phase.READY, t)

    def _flies(self, name: str) -> bool:
        return name in self._vehicles and self._vehicles[name].phase is Phase.FLYING

    def _watch(self, name: str, one: VehicleRecord, health: LinkHealth, t: float) -> None:
        if not health.connected:
            if one.phase is not Phase.OFFLINE:
                self._enter(name, Phase.OFFLINE, t)
            return
        if one.cut_again(t, locked=health.locked):
            self._links[name].cut()  # the first may be lost on the way, or the link was down
        if one.phase is Phase.OFFLINE:
            self._resume(name, one, health, t)
        elif one.phase is Phase.ARMING:
            self._watch_arming(name, one, health, t)
        elif one.phase in {Phase.CLIMBING, Phase.FLYING}:
            self._watch_flight(name, one, health, t)
        elif one.phase is Phase.LANDING and t - one.since > one.landing_s:
            self._enter(name, Phase.READY, t)

    def _resume(self, name: str, one: VehicleRecord, health: LinkHealth, t: float) -> None:
        """Resume the phase of a vehicle that is connected again, once it says whether it flies."""
        if one.lost is None or health.flying is False or health.locked:
            self._enter(name, Phase.READY, t)
        elif health.flying and one.lost is Phase.CLIMBING:
            self._enter(name, Phase.CLIMBING, t)
        elif health.flying:
            one.phase, one.lost = one.lost, None
            self._land(name, t)

    def _watch_arming(self, name: str, one: VehicleRecord, health: LinkHealth, t: float) -> None:
        if health.armed:
            if self._hover is not None:
                self._links[name].send_rpyt(ZERO_RPYT)
            self._enter(name, Phase.ARMED, t)
        elif t - one.since > self._params.arm_s:
            self._enter(name, Phase.READY, t)

    def _watch_flight(self, name: str, one: VehicleRecord, health: LinkHealth, t: float) -> None:
        if health.locked:
            self._enter(name, Phase.READY, t)
            self._log.append(f"{name} is locked and must be restarted")
            return
        one.low_since = min(one.low_since, t) if health.volt < self._params.volt_land else np.inf
        if t - one.low_since >= self._params.volt_land_s:
            self._log.append(f"{name} has {health.volt:.2f} V and lands")
            self._land(name, t)

    def _watch_silence(self, name: str, one: VehicleRecord, t: float) -> None:
        silent, limits = t - one.commanded_at, self._params
        if silent < limits.silent_s or not np.isfinite(silent):
            return
        if silent < limits.silent_land_s:
            self._hold(name, one)
        elif self._hover is None or t - one.measured_at <= self._landing.stale_s:
            self._log.append(f"{name} has no command for {limits.silent_land_s} s and lands")
            self._land(name, t)
        elif silent < limits.silent_stop_s:
            share = FallbackParams().land_share
            self._links[name].send_rpyt(replace(self._hover, pwm=round(share * self._hover.pwm)))
        else:
            self._log.append(f"{name} has no command for {limits.silent_stop_s} s and descended blind")
            self._cut_one(name, t)

    def _hold(self, name: str, one: VehicleRecord) -> None:
        """Send a setpoint that keeps a vehicle in place."""
        if self._hover is not None:
            self._links[name].send_rpyt(self._hover)
        elif one.full_state is not None:
            zero = (0.0, 0.0, 0.0)
            self._links[name].send_full_state(replace(one.full_state, vel=zero, acc=zero, ang_vel=zero))

    def _land(self, name: str, t: float) -> None:
        one = self._vehicles[name]
        one.landing_s = self._landing.duration(one.height - self._ground)
        self._links[name].land(self._ground, one.landing_s)
        self._enter(name, Phase.LANDING, t)

    def _enter(self, name: str, phase: Phase, t: float) -> None:
        one = self._vehicles[name]
        if one.phase in AIRBORNE and phase is Phase.OFFLINE:
            self._log.append(f"{name} is lost in flight: {ON_BOARD[one.phase]}")
        elif one.phase is not phase:
            self._log.append(f"{name} is {phase.value}")
        one.enter(phase, t)
