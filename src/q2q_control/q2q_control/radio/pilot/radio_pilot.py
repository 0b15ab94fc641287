"""Pilot that executes the procedure's orders over the radio, and passes states and commands to the vehicles.

Each vehicle has a phase, and lands or is cut by itself (q2q_control.radio.pilot.vehicle_pilot).

| event | what happens |
|---|---|
| state older than stale_s | no pose is sent; the firmware's estimate coasts |
| command with status CUT | the vehicle's motors are cut and locked |
| a command that is not finite | it is not sent, and counts as none; the other vehicles' are sent |

The procedure decides whether vehicles may be armed (q2q_control.flight_procedure).

A vehicle's pose is sent once per frame, and only if it was measured in that frame, moved on by
pose_delay_s (q2q_model.geometry.pose_ahead); where no attitude was ever measured, only its position is.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from q2q_control.flight_procedure.procedure_params import LandingParams
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import FullState, RpytSetpoint
from q2q_control.radio.link.vehicle_link import VehicleLink
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.vehicle_pilot import PilotSetup, VehiclePilot
from q2q_control.radio.pilot.vehicle_record import AIRBORNE, Phase
from q2q_model.counted import listed
from q2q_model.estimation.attitude.attitude_tracks import measured_attitudes
from q2q_model.geometry.pose_ahead import extrapolate_pose
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names, SwarmState, TrackStatus


class RadioPilot:
    """Pilots of all vehicles, and the pending order."""

    def __init__(
        self,
        links: Mapping[str, VehicleLink],
        params: RadioPilotParams,
        hover: RpytSetpoint | None,
        landing: LandingParams | None = None,
        ground_height: float = 0.0,
    ) -> None:
        """Fly by RPYT setpoints, the level one `hover`, or by full states if None.

        Vehicles land at `ground_height` [m].
        """
        self._params = params
        self._order: Order | None = None
        self._ordered = -np.inf
        self._last_stamp = -np.inf
        self._log: list[str] = []
        setup = PilotSetup(params, landing or LandingParams(), ground_height, hover)
        self._vehicles = {
            name: VehiclePilot(name, link, setup, self._log.append) for name, link in links.items()
        }

    @property
    def phases(self) -> dict[str, Phase]:
        """Return the phase of every vehicle."""
        return {name: one.phase for name, one in self._vehicles.items()}

    @property
    def motors_cut(self) -> frozenset[str]:
        """Return the vehicles whose motors were cut since they were armed."""
        return frozenset(name for name, one in self._vehicles.items() if one.motors_cut)

    def landing_left(self, t: float) -> float:
        """Return the time from t [s] until the last landing has ended [s]; 0 if none is under way."""
        return max((0.0, *(one.landing_end - t for one in self._in_the_air(Phase.LANDING))))

    def log_lines(self) -> list[str]:
        """Return and clear the log lines."""
        lines = self._log.copy()
        self._log.clear()
        return lines

    def begin(self, order: Order, t: float) -> None:
        """Start executing an order at time t [s]; `outcome` returns its result."""
        self._order, self._ordered = order, t
        if order.act is Act.LAND:
            self.land(t)
        elif order.act is Act.EMERGENCY:
            self.cut_all(t)
        for one in self._vehicles.values():
            one.carry_out(order, t)

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order by time t [s], once; None while it is unknown."""
        order = self._order
        if order is None:
            return None
        if order.act is Act.ARM:
            reply = self._arming_outcome()
        elif order.act is Act.EMERGENCY:
            reply = self._stop_outcome()
        else:
            reply = self._order_outcome(order.act, t)
        if reply is not None:
            self._order = None
        return reply

    def land(self, t: float) -> bool:
        """Land all flying vehicles by themselves; return whether any lands, from now or from before."""
        for one in self._in_the_air(Phase.CLIMBING, Phase.FLYING):
            one.land(t)
        return bool(self._in_the_air(Phase.LANDING))

    def cut_all(self, t: float) -> None:
        """Cut and lock all motors."""
        for one in self._vehicles.values():
            one.cut(t)

    def cut(self, names: Names, t: float) -> None:
        """Cut and lock the motors of these vehicles, which are commanded CUT, if they fly."""
        for name in names:
            if name in self._vehicles and self._vehicles[name].air_phase in AIRBORNE:
                self._log.append(f"{name} received CUT: motors stopped")
                self._vehicles[name].cut(t)

    def watch(self, t: float) -> None:
        """Check links, batteries and missing commands at time t [s]."""
        for one in self._vehicles.values():
            one.watch(t)

    def update_state(self, state: SwarmState, t: float, *, send: bool = True) -> None:
        """Store a frame's state received at time t [s]; send the poses measured in it, once."""
        fresh = (state.status == TrackStatus.TRACKED) & np.isfinite(state.pos).all(axis=1)
        skip_sending = state.t == self._last_stamp or not send
        self._last_stamp = state.t
        pos, quat = extrapolate_pose(state, self._params.pose_delay_s)
        turned = measured_attitudes(state)
        for row, name in enumerate(state.names):
            if name not in self._vehicles or not fresh[row]:
                continue
            self._vehicles[name].measured(float(state.pos[row, 2]), t)
            if not skip_sending:
                attitude = quat[row].tolist() if turned[row] else None
                self._vehicles[name].send_pose(pos[row].tolist(), attitude)

    def fly_rpyt(self, names: Names, rpyt_setpoints: Sequence[RpytSetpoint | None], t: float) -> None:
        """Send a tick's RPYT setpoints, received at time t [s], to the flying vehicles; None: no command."""
        for name, one in zip(names, rpyt_setpoints, strict=True):
            if one is not None and name in self._vehicles:
                self._vehicles[name].fly_rpyt(one, t)

    def fly_full_states(self, names: Names, states: Sequence[FullState | None], t: float) -> None:
        """Send a tick's full states, received at time t [s], to the flying vehicles; None: no command."""
        for name, one in zip(names, states, strict=True):
            if one is not None and name in self._vehicles:
                self._vehicles[name].fly_full_state(one, t)

    def _arming_outcome(self) -> Reply | None:
        """Return the outcome of arming; None while it goes on."""
        if any(one.phase is Phase.ARMING for one in self._vehicles.values()):
            return None
        missing = [name for name, one in self._vehicles.items() if one.phase is not Phase.ARMED]
        reason = f"{listed(missing)} did not arm within {self._params.arm_s:g} s" if missing else ""
        return Reply(granted=not missing, reason=reason)

    def _stop_outcome(self) -> Reply | None:
        """Return the outcome of a stop; None until connected vehicles are locked or were sent it for 2 s."""
        if any(one.stopping for one in self._vehicles.values()):
            return None
        offline = [name for name, phase in self.phases.items() if phase is Phase.OFFLINE]
        if not offline:
            return Reply(granted=True)
        stopped = [name for name in self._vehicles if name not in offline]
        missed = f"{listed(offline)} not reached: motors will be stopped when radio reconnects"
        done = f"; motors of {listed(stopped)} stopped; restart the vehicles" if stopped else ""
        return Reply(granted=False, reason=missed + done)

    def _order_outcome(self, act: Act, t: float) -> Reply | None:
        if act is not Act.DISARM:
            return Reply(granted=True)
        armed = [name for name, one in self._vehicles.items() if one.armed]
        if armed and t - self._ordered < self._params.arm_s:
            return None
        reason = f"{listed(armed)} armed again: their firmware arms itself" if armed else ""
        return Reply(granted=not armed, reason=reason)

    def _in_the_air(self, *phases: Phase) -> list[VehiclePilot]:
        """Return the vehicles in some phases; those lost in the air by the one on board."""
        return [one for one in self._vehicles.values() if one.air_phase in phases]
