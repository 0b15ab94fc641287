"""Names of the topics of a flight: those of every tick, with their signals, and those of other messages."""

from q2q_model.signals.layout import Signal
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
PLAN, NEXT_PLAN = "plan", "next_plan"
"""The plan that is flown, and the one that follows. Latched."""
MODEL = "model"
"""Model file in use. Latched."""
FLIGHT_SUMMARY = "flight_summary"
"""What the simulator knows of the flight at its end. Latched."""
PLAYBACK_OVER = "playback_over"
"""End of a bag that is played. Latched."""
PREDICTIONS = "predictions"
"""Predictions of a distributed MPC, one message of each vehicle a slot."""
