"""Layout of each signal in its message: field and numbers per vehicle.

Nodes (rclpy messages) and bags (rosbags messages) share this table, so a signal has the same layout on a
topic and in a file.
"""

from dataclasses import dataclass, fields

from q2q_model.signals.values import (
    Interference,
    MocapFrame,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
)

Signal = MocapFrame | SwarmState | SwarmSetpoint | Interference | SwarmCommand | SwarmImu


@dataclass(frozen=True, slots=True)
class Column:
    """One array of a signal and the flat array of its message."""

    attribute: str
    """Field of the signal dataclass."""
    field: str
    """Field of the message."""
    width: int
    """Numbers per vehicle: 1, 3 or 4."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Mapping of one signal class to one message type."""

    message: str
    """Type name within q2q_msgs."""
    columns: tuple[Column, ...]


_FIELDS = {
    "pos": ("position", 3),
    "vel": ("velocity", 3),
    "quat": ("orientation", 4),
    "ang_vel_body": ("angular_velocity", 3),
    "specific_force_body": ("specific_force", 3),
    "acc": ("acceleration", 3),
    "std": ("deviation", 3),
    "age": ("age", 1),
    "yaw": ("yaw", 1),
    "yaw_rate": ("yaw_rate", 1),
    "thrust": ("thrust", 1),
    "roll": ("roll", 1),
    "pitch": ("pitch", 1),
    "status": ("status", 1),
}


def _layout(signal: type[Signal]) -> Layout:
    arrays = [entry.name for entry in fields(signal) if entry.name not in ("t", "names")]
    columns = tuple(Column(name, *_FIELDS[name]) for name in arrays)
    return Layout(message=signal.__name__, columns=columns)


LAYOUTS: dict[type, Layout] = {
    signal: _layout(signal)
    for signal in (MocapFrame, SwarmState, SwarmSetpoint, Interference, SwarmCommand, SwarmImu)
}
SIGNALS: dict[str, type[Signal]] = {
    f"q2q_msgs/msg/{layout.message}": signal for signal, layout in LAYOUTS.items()
}
"""Message type to signal class."""
