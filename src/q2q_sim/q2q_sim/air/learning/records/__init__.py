"""Recorded flights as the terms of an air need them: motion, forces and torques, thrust of the motors."""
