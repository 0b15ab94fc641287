"""Air models: downwash, residual, torque, ground effect and wind, learned from recorded flights."""
