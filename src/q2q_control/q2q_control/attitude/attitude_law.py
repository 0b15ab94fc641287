"""Onboard attitude loop: U2 to U4 of eqs (1)-(3) as a PD law on Euler angles.

Source: section 5.1 ("the attitude control approach is similar to the altitude control"): feedback
linearisation of (1)-(3) by cancelling the gyroscopic terms, then a PD law in natural-frequency form, so that
vehicles of any inertia respond alike:

    v_phi = w_n^2 (phi_d - phi) - 2 zeta w_n p           (theta, q likewise)
    v_psi = k_r (r_d - r)
    tau   = I v + omega x (I omega)                       tau_x = l U2, tau_y = l U3, tau_z = U4
    tau_c = tau + T dtau/dt,   domega/dt = tau_now / I    (lead: compensates the lag T of the rotors)

With T the rotors' lag the loop is exactly phi / phi_d = w_n^2 / ((s^2 + 2 zeta w_n s + w_n^2)(T s + 1));
without lead a lag of 0.07 s leaves w_n = 15 rad/s almost undamped. U2 and U3 of the paper are forces at
the arm l, with b1 = l/Ixx and b2 = l/Iyy; here all three inputs are torques, and b1, b2, b3 are 1/Ixx, 1/Iyy,
1/Izz (the paper's b3 = l/Izz would hold for a force). The coefficients a1 to a5 are given by the inertia.

| symbol | name | meaning [unit] |
|---|---|---|
| phi theta psi | attitude | roll, pitch, yaw [rad] |
| omega = p q r | ang_vel_body | body rates [rad/s] |
| phi_d theta_d r_d | desired | roll, pitch [rad], yaw rate [rad/s] |
| tau | torque | about body axes [N m] |
| tau_now | torque_now | present torque of the rotors [N m] |
| w_n zeta | frequency damping | of roll and pitch [rad/s], [-] |
| k_r | yaw_bandwidth | [1/s] |
| T | lead | [s] |
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle

AxisValues = Array | tuple[float, float, float]
"""One number for each body axis x, y, z."""


@dataclass(frozen=True, slots=True)
class AttitudeParams:
    """Bandwidths of the attitude loop."""

    frequency: float = tunable(
        15.0,  # as fast as the firmware's Mellinger loop; 7 times the position loop's 2 rad/s
        "natural frequency of roll and pitch",
        unit="rad/s",
        low=1.0,
        high=100.0,
    )
    damping: float = tunable(0.9, "damping ratio of roll and pitch: 5 % overshoot at most", low=0.1, high=3.0)
    yaw_bandwidth: float = tunable(5.0, "yaw rate error to yaw acceleration", unit="1/s", low=0.1, high=100.0)
    lead_ratio: float = tunable(
        1.0, "lead time over the vehicle's thrust lag: 1 cancels the lag, 0 ignores it", low=0.0, high=1.0
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class AttitudeGains(NamedTuple):
    """Constants of the attitude law of one vehicle, about the body axes x, y, z."""

    stiffness: AxisValues
    """I w_n^2 [N m/rad]; 0 about z."""
    damping: AxisValues
    """2 I zeta w_n, about z I k_r [N m s/rad]."""
    inertia: AxisValues
    """[kg m^2]"""
    lead: float
    """[s]"""


def attitude_gains(params: AttitudeParams, vehicle: Vehicle) -> AttitudeGains:
    """Return the constants of the laws below for a vehicle."""
    inertia = np.array(vehicle.inertia)
    stiffness = inertia * np.array([params.frequency**2, params.frequency**2, 0.0])
    tilt_damping = 2.0 * params.damping * params.frequency
    damping = inertia * np.array([tilt_damping, tilt_damping, params.yaw_bandwidth])
    return AttitudeGains(stiffness, damping, inertia, params.lead_ratio * vehicle.thrust_lag)


def attitude_torques(
    attitude: Array, ang_vel_body: Array, torque_now: Array, desired: Array, gains: AttitudeGains
) -> Array:
    """Return the torques [N m], body, (..., 3); arguments are (..., 3)."""
    stiffness, damping, inertia = map(np.asarray, gains[:3])
    yaw_only = np.array([0.0, 0.0, 1.0])
    angle_error = (desired - attitude) * (1.0 - yaw_only)
    rate_desired = desired * yaw_only
    torque = stiffness * angle_error + damping * (rate_desired - ang_vel_body)
    growth = -stiffness * ang_vel_body - damping * torque_now / inertia
    gyroscopic = np.cross(ang_vel_body, inertia * ang_vel_body)
    return np.asarray(torque + gains.lead * growth + gyroscopic)


@compiled
def attitude_torque(
    attitude: AxisValues,
    ang_vel_body: AxisValues,
    torque_now: AxisValues,
    desired: AxisValues,
    gains: AttitudeGains,
) -> tuple[float, float, float]:
    """Return tau_x, tau_y, tau_z [N m] of one vehicle for compiled loops; arguments as `attitude_torques`."""
    p, q, r = ang_vel_body[0], ang_vel_body[1], ang_vel_body[2]
    stiffness, damping, inertia, lead = gains
    ix, iy, iz = inertia[0], inertia[1], inertia[2]
    roll = stiffness[0] * (desired[0] - attitude[0] - lead * p)
    roll -= damping[0] * (p + lead * torque_now[0] / ix)
    pitch = stiffness[1] * (desired[1] - attitude[1] - lead * q)
    pitch -= damping[1] * (q + lead * torque_now[1] / iy)
    yaw = damping[2] * (desired[2] - r - lead * torque_now[2] / iz)
    return roll + (iz - iy) * q * r, pitch + (ix - iz) * p * r, yaw + (iy - ix) * p * q
