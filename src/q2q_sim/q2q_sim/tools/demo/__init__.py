"""Flights and pages of the demo."""
