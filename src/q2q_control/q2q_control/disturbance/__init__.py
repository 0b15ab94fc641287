"""Disturbance observers: commands in effect, thrust, and unexplained acceleration."""
