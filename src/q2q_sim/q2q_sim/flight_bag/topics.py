"""Topics of a flight and their types: the contents of a bag."""

from q2q_model.signals.layout import LAYOUTS
from q2q_model.signals.topic_names import FLIGHT_SUMMARY, MODEL, NEXT_PLAN, PLAN, PLAYBACK_OVER, TICK_TOPICS

TYPE_NAMES: dict[str, str] = {
    topic: f"q2q_msgs/msg/{LAYOUTS[kind].message}" for topic, kind in TICK_TOPICS.items()
}
"""Topic to message type."""

LATCHED_TYPES: dict[str, str] = {
    PLAN: "q2q_msgs/msg/Plan",
    NEXT_PLAN: "q2q_msgs/msg/Plan",
    MODEL: "std_msgs/msg/String",
    FLIGHT_SUMMARY: "std_msgs/msg/String",
    PLAYBACK_OVER: "std_msgs/msg/String",
    "status": "diagnostic_msgs/msg/DiagnosticStatus",
}
"""Last part of a latched topic's name to its message type."""


def is_latched(topic: str, kind: str) -> bool:
    """Return whether q2q's nodes latch a topic of a message type, in any namespace."""
    return LATCHED_TYPES.get(topic.rpartition("/")[2]) == kind


def has_one_writer(topic: str) -> bool:
    """Return whether one node writes a topic of a flight, in any namespace."""
    return topic.rpartition("/")[2] in {*TYPE_NAMES, PLAN, NEXT_PLAN, MODEL}


PREDICTION_TYPE = "q2q_msgs/msg/Prediction"
"""Message type of PREDICTIONS."""
