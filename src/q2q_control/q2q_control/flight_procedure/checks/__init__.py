"""Checks of a flight procedure: before take-off, before setpoints are flown, and of arrival."""
