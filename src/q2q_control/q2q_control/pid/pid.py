"""PID of section 5.1, with or without downwash compensation: eqs (22)-(25).

    a     = r''_ref + K_p s (r_ref - r) + K_d (r'_ref - r') + K_i xi - eta     on x, y, z
    xi'   = r_ref - r                                                          (23)
    s     = min(1, e / |r_ref - r|),  K_p e = K_d v_max                        horizontally, and vertically
    U1, phi_d, theta_d, r_d from a by q2q_control.attitude.thrust_vector

s is ours: from further than e a vehicle returns at v_max relative to its setpoint. By the linear law one that
is carried 4 m up falls at 6 m/s, which no thrust stops above the floor.

eta is 0 without an Interference: the controller ignores the downwash. Every vehicle uses its own row only
(its neighbours enter through its downwash), so one node may control all vehicles or one each.

The state is K_i xi [m/s^2], so that a gain change causes no jump. Anti-windup: no integration while s < 1, or
while a limit is active in the direction of the error (conditional integration; Astrom, Hagglund, Advanced PID
Control, 2006, section 3.5), and |K_i xi| <= integral_max. A repeated stamp returns the same command; a stamp
that goes back resets all memory.

Gains: those of the altitude are the loop identified from flights (the paper's figure 5). The paper gives none
for the position: 2 rad/s at a damping of 0.9, a seventh of the attitude loop's frequency.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d K_i | k_p k_d k_i | [1/s^2], [1/s], [1/s^3] |
| K_i xi | integral | [m/s^2], (n, 3) |
| v_max, e | return_speed_max, error_max | [m/s], [m] |
| eta | eta | downwash acceleration [m/s^2], (n, 3) |
"""

import math

import numpy as np

from q2q_control.attitude.thrust_vector import ThrustLimits, largest_thrust
from q2q_control.failsafe.last_commands import HoldThenLevel, LastCommands
from q2q_control.inputs.alignment import Aligned, align
from q2q_control.pid.pid_kernel import Law, PidGains, pid_commands
from q2q_control.pid.pid_params import PidParams
from q2q_control.pid.stale_downwash_fade import StaleDownwashFade
from q2q_model.signals.repeated_stamp import is_repeated
from q2q_model.signals.values import (
    Interference,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    rows_by_name,
)
from q2q_model.vehicle.constants import Vehicle

DT_MAX = 0.1
"""Longest integration step [s]: after a gap the error's history is unknown."""


class Pid:
    """PID of all vehicles, with its integrals and last commands."""

    def __init__(self, params: PidParams, vehicle: Vehicle, vehicles: Names = ()) -> None:
        """Control vehicles like `vehicle`: those named, or all of the setpoint."""
        self._vehicle = vehicle
        self._vehicles = vehicles
        self._rows = LastCommands(HoldThenLevel(params.hold_duration, vehicle.hover_thrust))
        self._stale_fade = StaleDownwashFade(params.stale_fade)
        self.configure(params)
        self.reset()

    def configure(self, params: PidParams) -> None:
        """Use other parameters from the next stamp on; memory is kept.

        Raises:
            ValueError: thrust_max does not carry the vehicle.
        """
        limits = pid_limits(params, self._vehicle)
        self._law: Law = (*pid_gains(params),), (*limits,)
        hover = min(self._vehicle.hover_thrust, limits.thrust_max)
        self._rows.rule = HoldThenLevel(params.hold_duration, hover)

    def reset(self) -> None:
        """Forget integrals and last commands."""
        self._names: Names = ()
        self._integral = np.zeros((0, 3))
        self._rows.reset()
        self._stale_fade.reset()
        self._last: SwarmCommand | None = None

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the downwash."""
        last = self._last
        names = self._vehicles or setpoint.names
        if is_repeated(last, setpoint.t, names):
            return last
        if last is not None and setpoint.t < last.t:
            self.reset()
        return self.command(align(state, setpoint, self._stale_fade.faded(interference), names))

    def command(self, tick: Aligned) -> SwarmCommand:
        """Return the command of a tick that is newer than all before."""
        dt = min(tick.t - self._last.t, DT_MAX) if self._last is not None else 0.0
        if tick.names != self._names:
            self._integral = rows_by_name(self._integral, self._names, tick.names)
            self._names = tick.names
        out, status = np.empty((4, len(tick.names))), np.empty(len(tick.names), dtype=np.uint8)
        now = tick.t, max(dt, 0.0), tick.table, tick.usable
        memory = self._integral, self._rows.memory(tick.names)
        pid_commands(now, self._law, memory, self._rows.rule.numbers, (out, status))
        self._last = SwarmCommand(tick.t, tick.names, out[0], out[1], out[2], out[3], status)
        return self._last


def pid_gains(params: PidParams) -> PidGains:
    """Return the gains of x, y, z."""
    return PidGains(
        k_p=np.array([params.k_p_xy, params.k_p_xy, params.k_p_z]),
        k_d=np.array([params.k_d_xy, params.k_d_xy, params.k_d_z]),
        k_i=np.array([params.k_i_xy, params.k_i_xy, params.k_i_z]),
        integral_max=np.full(3, params.integral_max),
        error_max=(
            _error_max(params.k_p_xy, params.k_d_xy, params.return_speed_max),
            _error_max(params.k_p_z, params.k_d_z, params.return_speed_max),
        ),
    )


def _error_max(k_p: float, k_d: float, speed: float) -> float:
    """Return the error [m] at which a loop without acceleration moves at `speed` [m/s]; inf without k_d."""
    return k_d * speed / k_p if k_p > 0.0 and k_d > 0.0 else math.inf


def pid_limits(params: PidParams, vehicle: Vehicle) -> ThrustLimits:
    """Return the limits of a vehicle: its own, and those of the parameters.

    Raises:
        ValueError: thrust_max does not carry the vehicle.
    """
    return ThrustLimits(
        mass=vehicle.mass,
        thrust_max=largest_thrust(vehicle, params.thrust_max if params.thrust_limited else None),
        tilt_max=params.tilt_max,
        exact=params.exact_inverse,
        k_yaw=params.k_yaw,
        yaw_rate_max=params.yaw_rate_max,
    )
