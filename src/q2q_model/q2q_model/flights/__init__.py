"""Recorded flights as arrays over time."""
