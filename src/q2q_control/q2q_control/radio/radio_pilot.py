"""Carry out the flight procedure's orders over the radio, vehicle by vehicle, and land or stop by itself.

    OFFLINE <-> READY -- arm --> ARMING --> ARMED -- take off --> CLIMBING -- stream --> FLYING
                  ^                           |                      |                     |
                  +---------- disarm ---------+------ LANDING <------+--- land ------------+

| event | what happens |
|---|---|
| armed | sticks: one without thrust unlocks the motors |
| arming takes longer than arm_s | back to READY |
| flying | every tick's command is sent; before that, none |
| link lost in flight | nothing is sent; the firmware levels after 0.5 s and cuts after 2 s |
| battery below volt_land for volt_land_s | that vehicle lands by itself, whatever is commanded |
| state older than stale_s | no place is sent; the firmware's estimate coasts |
| a command says CUT | that vehicle's motors are stopped for good |
| no command for silent_s | sticks: level at hover thrust; full states: a hover where it was last sent |
| none for silent_land_s | it lands by itself |
| the same, by stick without a fresh state | it sinks level, at the ladder's land_share of hover |
| the same for silent_stop_s | its motors are stopped for good |

The last four keep the firmware's watchdog fed (it levels after 0.5 s and cuts after 2 s) while the radio
lives and a controller does not; they begin with the first command in flight, and end with the next one
that comes before the landing. Whether vehicles may be armed is the procedure's to say
(q2q_control.flight_procedure).

A vehicle's place is sent once a frame, and only where it was measured in that frame.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link import LinkHealth, VehicleLink
from q2q_control.radio.pilot_params import RadioPilotParams
from q2q_control.radio.setpoints import ZERO_STICK, FullState, RpytSetpoint
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names, SwarmState, TrackStatus


class Phase(Enum):
    """Name what a vehicle is doing."""

    OFFLINE = "offline"
    READY = "ready"
    ARMING = "arming"
    ARMED = "armed"
    CLIMBING = "climbing"
    """By its own commander, which then holds it."""
    FLYING = "flying"
    LANDING = "landing"


AIRBORNE = frozenset({Phase.CLIMBING, Phase.FLYING, Phase.LANDING})


@dataclass(slots=True)
class _Vehicle:
    """Hold what the pilot remembers of a vehicle."""

    phase: Phase = Phase.OFFLINE
    since: float = 0.0
    """When the phase began [s]."""
    seen: float = -np.inf
    """When the last state came that was measured [s]."""
    low_since: float = np.inf
    """Since when the battery is low [s]."""
    heard: float = -np.inf
    """When it was last commanded [s]; not since its start: never."""
    height: float = 0.0
    """Where it was last measured [m]."""
    landing_s: float = 0.0
    """How long its landing takes [s]."""
    wanted: FullState | None = None
    """The last full state it was sent."""


class RadioPilot:
    """Hold the phase of every vehicle."""

    def __init__(
        self,
        links: Mapping[str, VehicleLink],
        params: RadioPilotParams,
        hover: RpytSetpoint | None,
        landing: LandingParams | None = None,
    ) -> None:
        """Fly vehicles over their links: by sticks, `hover` the level one, or by full states where None."""
        self._links = dict(links)
        self._params = params
        self._landing = landing or LandingParams()
        self._order: Order | None = None
        self._asked = -np.inf
        self._hover = hover
        self._vehicles = {name: _Vehicle() for name in links}
        self._last_stamp = -np.inf
        self._said: list[str] = []

    @property
    def phases(self) -> dict[str, Phase]:
        """Return every vehicle's phase."""
        return {name: one.phase for name, one in self._vehicles.items()}

    @property
    def landing_s(self) -> float:
        """Return how long the longest landing that has begun takes [s]."""
        return max((one.landing_s for one in self._vehicles.values()), default=0.0)

    def said(self) -> list[str]:
        """Return, and forget, what happened since the last call, a line each."""
        lines, self._said = self._said, []
        return lines

    def begin(self, order: Order, t: float) -> None:
        """Begin to carry out an order at time t [s]; `outcome` tells what became of it."""
        self._order, self._asked = order, t
        if order.act is Act.ARM:
            self._each({Phase.READY}, self._arm_one, t)
        elif order.act is Act.TAKE_OFF:
            for name in self._in({Phase.ARMED}):
                self._links[name].take_off(order.height, order.duration)
                self._enter(name, Phase.CLIMBING, t)
        elif order.act is Act.STREAM:
            self._each({Phase.ARMED, Phase.CLIMBING}, self._fly_one, t)
        elif order.act is Act.LAND:
            self.land(t)
        elif order.act is Act.DISARM:
            self._each({Phase.ARMING, Phase.ARMED, Phase.LANDING, Phase.READY}, self._disarm_one, t)
        elif order.act is Act.CUT:
            self.stop(t)

    def outcome(self, t: float) -> Reply | None:
        """Return what became of the last order by time t [s], once; None while that is not known."""
        order = self._order
        if order is None:
            return None
        reply = self._armed() if order.act is Act.ARM else self._carried_out(order.act, t)
        if reply is not None:
            self._order = None
        return reply

    def land(self, t: float) -> bool:
        """Let all vehicles in the air land by themselves; return whether there are any."""
        flying = self._in({Phase.CLIMBING, Phase.FLYING})
        for name in flying:
            self._land(name, t)
        return bool(flying)

    def stop(self, t: float) -> None:
        """Stop all motors for good, whoever flies."""
        for name, link in self._links.items():
            link.stop()
            if self._vehicles[name].phase is not Phase.OFFLINE:
                self._enter(name, Phase.READY, t)

    def cut(self, names: Names, t: float) -> None:
        """Stop the motors of these vehicles for good, where they fly."""
        for name in names:
            if name in self._vehicles and self._vehicles[name].phase in AIRBORNE:
                self._links[name].stop()
                self._enter(name, Phase.READY, t)

    def watch(self, t: float, ahead: float = 0.0) -> None:
        """Look at links, batteries and silence at time t [s].

        Args:
            t: now [s].
            ahead: take a command as missing that will be within this time [s], where none is going to come.
        """
        for name, one in self._vehicles.items():
            self._watch(name, one, self._links[name].health(), t)
            if one.phase is Phase.FLYING:
                self._watch_silence(name, one, t, ahead)

    def places(self, state: SwarmState, t: float, *, send: bool = True) -> None:
        """Take a frame's state that came at time t [s]; send the places measured in it, once."""
        fresh = state.status == TrackStatus.TRACKED
        again = state.t == self._last_stamp or not send
        self._last_stamp = state.t
        for row, name in enumerate(state.names):
            if name not in self._vehicles or not fresh[row] or not np.isfinite(state.pos[row]).all():
                continue
            self._vehicles[name].seen, self._vehicles[name].height = t, float(state.pos[row, 2])
            if not again and self._vehicles[name].phase is not Phase.OFFLINE:
                self._links[name].send_place(state.pos[row].tolist(), state.quat[row].tolist())

    def fly_rpyt(self, names: Names, rpyt_setpoints: list[RpytSetpoint], t: float) -> None:
        """Send a tick's sticks, that came at time t [s], to the vehicles that fly."""
        for name, stick in zip(names, rpyt_setpoints, strict=True):
            if self._flies(name):
                self._vehicles[name].heard = t
                self._links[name].send_rpyt(stick)

    def fly_full_states(self, names: Names, wanted: list[FullState], t: float) -> None:
        """Send a tick's full states, that came at time t [s], to the vehicles that fly."""
        for name, one in zip(names, wanted, strict=True):
            if self._flies(name):
                self._vehicles[name].heard, self._vehicles[name].wanted = t, one
                self._links[name].send_full_state(one)

    def _armed(self) -> Reply | None:
        """Return how arming went; None while it goes on."""
        if self._in({Phase.ARMING}):
            return None
        missing = [name for name, one in self._vehicles.items() if one.phase is not Phase.ARMED]
        reason = f"{', '.join(missing)} did not arm within {self._params.arm_s:g} s" if missing else ""
        return Reply(granted=not missing, reason=reason)

    def _carried_out(self, act: Act, t: float) -> Reply | None:
        if act is not Act.DISARM:
            return Reply(granted=True)
        armed = [name for name, link in self._links.items() if link.health().armed]
        if armed and t - self._asked < self._params.arm_s:
            return None
        return Reply(
            granted=not armed,
            reason=f"{', '.join(armed)} armed again: the build arms itself" if armed else "",
        )

    def _in(self, phases: Collection[Phase]) -> list[str]:
        return [name for name, one in self._vehicles.items() if one.phase in phases]

    def _each(self, phases: Collection[Phase], act: Callable[[str, float], None], t: float) -> None:
        for name in self._in(phases):
            act(name, t)

    def _arm_one(self, name: str, t: float) -> None:
        one = self._vehicles[name]
        self._enter(name, Phase.ARMING, t)
        one.low_since, one.heard, one.wanted = np.inf, -np.inf, None
        self._links[name].arm()

    def _fly_one(self, name: str, t: float) -> None:
        self._enter(name, Phase.FLYING, t)

    def _disarm_one(self, name: str, t: float) -> None:
        self._links[name].disarm()
        self._enter(name, Phase.READY, t)

    def _flies(self, name: str) -> bool:
        return name in self._vehicles and self._vehicles[name].phase is Phase.FLYING

    def _watch(self, name: str, one: _Vehicle, health: LinkHealth, t: float) -> None:
        if not health.connected:
            if one.phase is not Phase.OFFLINE:
                self._enter(name, Phase.OFFLINE, t)
            return
        if one.phase is Phase.OFFLINE:
            self._enter(name, Phase.READY, t)
        elif one.phase is Phase.ARMING:
            self._arm(name, one, health, t)
        elif one.phase in {Phase.CLIMBING, Phase.FLYING}:
            self._watch_flight(name, one, health, t)
        elif one.phase is Phase.LANDING and t - one.since > one.landing_s:
            self._enter(name, Phase.READY, t)

    def _arm(self, name: str, one: _Vehicle, health: LinkHealth, t: float) -> None:
        if health.armed:
            if self._hover is not None:
                self._links[name].send_rpyt(ZERO_STICK)
            self._enter(name, Phase.ARMED, t)
        elif t - one.since > self._params.arm_s:
            self._enter(name, Phase.READY, t)

    def _watch_flight(self, name: str, one: _Vehicle, health: LinkHealth, t: float) -> None:
        if health.locked:
            self._enter(name, Phase.READY, t)
            self._said.append(f"{name} has stopped for good and must be restarted")
            return
        one.low_since = min(one.low_since, t) if health.volt < self._params.volt_land else np.inf
        if t - one.low_since >= self._params.volt_land_s:
            self._said.append(f"{name} has {health.volt:.2f} V and lands")
            self._land(name, t)

    def _watch_silence(self, name: str, one: _Vehicle, t: float, ahead: float) -> None:
        silent, limits = t - one.heard, self._params
        if silent + ahead < limits.silent_s or not np.isfinite(silent):
            return
        if silent < limits.silent_land_s:
            self._hold(name, one)
        elif self._hover is None or t - one.seen <= self._landing.stale_s:
            self._said.append(f"{name} has no command for {limits.silent_land_s} s and lands")
            self._land(name, t)
        elif silent < limits.silent_stop_s:
            share = FallbackParams().land_share
            self._links[name].send_rpyt(replace(self._hover, pwm=round(share * self._hover.pwm)))
        else:
            self._said.append(f"{name} has no command for {limits.silent_stop_s} s and sank blind")
            self.cut((name,), t)

    def _hold(self, name: str, one: _Vehicle) -> None:
        """Send what keeps a vehicle where it is."""
        if self._hover is not None:
            self._links[name].send_rpyt(self._hover)
        elif one.wanted is not None:
            zero = (0.0, 0.0, 0.0)
            self._links[name].send_full_state(replace(one.wanted, vel=zero, acc=zero, ang_vel=zero))

    def _land(self, name: str, t: float) -> None:
        one = self._vehicles[name]
        one.landing_s = self._landing.duration(one.height)
        self._links[name].land(one.landing_s)
        self._enter(name, Phase.LANDING, t)

    def _enter(self, name: str, phase: Phase, t: float) -> None:
        one = self._vehicles[name]
        if one.phase in AIRBORNE and phase is Phase.OFFLINE:
            self._said.append(f"{name} is lost in flight: its firmware levels out, then cuts its motors")
        elif one.phase is not phase:
            self._said.append(f"{name} is {phase.value}")
        one.phase, one.since = phase, t
