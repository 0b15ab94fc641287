"""Pilot of real vehicles: orders, phases, and what it does by itself."""
