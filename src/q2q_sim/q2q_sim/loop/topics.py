"""Topics of a flight and their types: the contents of a bag."""

from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import (
    Interference,
    MocapFrame,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
)

TICK_TOPICS: dict[str, type[Signal]] = {
    "mocap": MocapFrame,
    "truth": SwarmState,
    "truth_interference": Interference,
    "imu": SwarmImu,
    "state": SwarmState,
    "reference": SwarmSetpoint,
    "reference_safe": SwarmSetpoint,
    "interference": Interference,
    "command": SwarmCommand,
}
"""Topic to signal, in the order of the data flow."""

TYPE_NAMES: dict[str, str] = {
    topic: f"q2q_msgs/msg/{LAYOUTS[kind].message}" for topic, kind in TICK_TOPICS.items()
}
"""Topic to message type."""

PREDICTIONS, PREDICTION_TYPE = "predictions", "q2q_msgs/msg/Prediction"
"""Topic of a distributed MPC's predictions, one message of each vehicle a slot, and its message type."""
