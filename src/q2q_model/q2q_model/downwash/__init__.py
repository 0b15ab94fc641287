"""Interaction models: the acceleration eta that one vehicle's draft puts on another."""
