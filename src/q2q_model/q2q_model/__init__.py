"""Signals, vehicles, mocap filter, interaction models, identification."""
