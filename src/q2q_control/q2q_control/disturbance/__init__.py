"""Disturbance observers: commands in effect, thrust, and what neither explains."""
