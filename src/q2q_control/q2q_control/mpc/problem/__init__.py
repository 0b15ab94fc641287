"""The horizon's linear-quadratic problem: parameters, axis models, cost, bounds and downwash; build only."""
