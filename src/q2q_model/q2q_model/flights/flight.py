"""A recorded flight as arrays over time.

T ticks, n vehicles; NaN where nothing was recorded. Frames and units are those of q2q_model.signals.values.
"""

from dataclasses import dataclass, replace

from q2q_model.signals.layout import LAYOUTS
from q2q_model.signals.values import Array, Mask, Names


@dataclass(frozen=True, slots=True)
class Flight:
    """Record of one flight, one row per tick."""

    name: str
    names: Names
    t: Array
    """Capture stamps [s], rising, (T,)."""
    mocap_pos: Array
    """Motion capture position [m], (T, n, 3); NaN where a vehicle was not in the frame."""
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
    """True downwash acceleration [m/s^2], (T, n, 3)."""
    ref_pos: Array
    """Planned position [m], (T, n, 3)."""
    ref_vel: Array
    """Planned velocity [m/s], (T, n, 3)."""
    ref_acc: Array
    """Planned acceleration [m/s^2], (T, n, 3)."""
    safe_pos: Array
    """Position setpoint of the controller [m], (T, n, 3); replanned where a replanner ran."""
    safe_vel: Array
    """Velocity setpoint of the controller [m/s], (T, n, 3)."""
    safe_acc: Array
    """Acceleration setpoint of the controller [m/s^2], (T, n, 3)."""
    eta: Array
    """Predicted downwash acceleration [m/s^2], (T, n, 3)."""
    thrust: Array
    """Commanded collective thrust U1 [N], (T, n)."""
    roll: Array
    """Commanded phi [rad], (T, n)."""
    pitch: Array
    """Commanded theta [rad], (T, n)."""
    command_status: Array
    """CommandStatus as float, (T, n); NaN without a command."""
    specific_force_body: Array
    """Accelerometer [m/s^2], body, (T, n, 3)."""
    gyro_body: Array
    """Gyroscope [rad/s], body, (T, n, 3)."""


FLIGHT_FIELDS: dict[str, dict[str, str]] = {
    "truth": {"pos": "true_pos", "vel": "true_vel"},
    "mocap": {"pos": "mocap_pos", "quat": "mocap_quat"},
    "reference": {"pos": "ref_pos", "vel": "ref_vel", "acc": "ref_acc"},
    "state": {"pos": "pos", "vel": "vel", "quat": "quat"},
    "truth_interference": {"acc": "true_eta"},
    "reference_safe": {"pos": "safe_pos", "vel": "safe_vel", "acc": "safe_acc"},
    "interference": {"acc": "eta"},
    "command": {"thrust": "thrust", "roll": "roll", "pitch": "pitch", "status": "command_status"},
    "imu": {"specific_force_body": "specific_force_body", "ang_vel_body": "gyro_body"},
}
"""Topic -> attribute of its signal -> field of Flight. The first topic present defines the ticks; see
flight_ticks for a truth that does not cover the frames."""

FIELD_WIDTHS = {
    field: column.width
    for fields in FLIGHT_FIELDS.values()
    for attribute, field in fields.items()
    for layout in LAYOUTS.values()
    for column in layout.columns
    if column.attribute == attribute
}
"""Field of Flight -> its numbers for each vehicle and tick."""


def of_vehicle(flight: Flight, name: str) -> Flight:
    """Return the flight of one vehicle, in views of the arrays.

    Raises:
        ValueError: the vehicle is not in the flight.
    """
    row = flight.names.index(name)
    made = {field: getattr(flight, field)[:, row : row + 1] for field in FIELD_WIDTHS}
    return replace(flight, names=(name,), **made)


def flight_of_vehicles(flight: Flight, names: Names) -> Flight:
    """Return the flight of some vehicles.

    Raises:
        ValueError: a vehicle is not in the flight.
    """
    rows = [flight.names.index(name) for name in names]
    made = {field: getattr(flight, field)[:, rows] for field in FIELD_WIDTHS}
    return replace(flight, names=names, **made)


def of_rows(flight: Flight, rows: slice | Mask) -> Flight:
    """Return some ticks of a flight: of a slice in views of the arrays, of a mask (T,) in copies."""
    made = {field: getattr(flight, field)[rows] for field in FIELD_WIDTHS}
    return replace(flight, t=flight.t[rows], **made)
