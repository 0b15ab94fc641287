"""Explicit MPC: the receding horizon distilled into a law for the vehicle's own processor (section 5.2)."""
