"""Hold a recorded flight as arrays over time: what identification, metrics and reports read.

T ticks, n vehicles. What a flight does not have is NaN. Frames and units are those of
q2q_model.signals.
"""

from dataclasses import dataclass

from q2q_model.signals import Array, Names


@dataclass(frozen=True, slots=True)
class Flight:
    """Hold one flight, one row a tick."""

    name: str
    names: Names
    t: Array
    """Capture stamps [s], rising, (T,)."""
    mocap_pos: Array
    """What motion capture saw [m], (T, n, 3); NaN where a vehicle was not in the frame."""
    mocap_quat: Array
    """(T, n, 4)"""
    pos: Array
    """Filtered position [m], (T, n, 3)."""
    vel: Array
    """Filtered velocity [m/s], (T, n, 3)."""
    quat: Array
    """Filtered orientation x y z w, (T, n, 4)."""
    true_pos: Array
    """True position [m], (T, n, 3); NaN outside a simulator."""
    true_vel: Array
    """True velocity [m/s], (T, n, 3)."""
    true_eta: Array
    """True draft acceleration [m/s^2], (T, n, 3)."""
    ref_pos: Array
    """Planned position [m], (T, n, 3)."""
    ref_vel: Array
    """Planned velocity [m/s], (T, n, 3)."""
    ref_acc: Array
    """Planned acceleration [m/s^2], (T, n, 3)."""
    safe_pos: Array
    """Position the controller was given [m], (T, n, 3): replanned where a replanner ran."""
    safe_vel: Array
    """Velocity the controller was given [m/s], (T, n, 3)."""
    safe_acc: Array
    """Acceleration the controller was given [m/s^2], (T, n, 3)."""
    eta: Array
    """Predicted draft acceleration [m/s^2], (T, n, 3)."""
    thrust: Array
    """Commanded collective thrust U1 [N], (T, n)."""
    roll: Array
    """Commanded phi [rad], (T, n)."""
    pitch: Array
    """Commanded theta [rad], (T, n)."""
    command_status: Array
    """CommandStatus as float, (T, n); NaN where no command."""
    specific_force_body: Array
    """What the accelerometer read [m/s^2], body, (T, n, 3)."""
    gyro_body: Array
    """What the gyroscope read [rad/s], body, (T, n, 3)."""
