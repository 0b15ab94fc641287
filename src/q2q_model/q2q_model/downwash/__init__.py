"""Interaction models: the acceleration eta that one vehicle's downwash puts on another."""
