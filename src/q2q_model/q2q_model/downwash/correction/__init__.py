"""Residual of an interaction model: measured, as a random process, and as a correction."""
