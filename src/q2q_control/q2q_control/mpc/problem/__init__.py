"""The horizon's linear-quadratic problem: build only."""
