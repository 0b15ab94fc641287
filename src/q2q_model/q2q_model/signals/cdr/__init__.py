"""Serialized messages of q2q_msgs."""
