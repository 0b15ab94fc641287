"""Explicit MPC: the MPC distilled into a small law for the vehicle's own processor (section 5.2)."""
