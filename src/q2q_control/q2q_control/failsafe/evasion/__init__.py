"""Setpoints around vehicles that are not measured, and of those measured again."""
