"""Recorded flights as the terms of an air need them: motion, pushes and rates, thrust of the motors."""
