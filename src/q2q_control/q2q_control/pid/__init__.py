"""Interaction-aware PID, section 5.1."""
