"""Simulated sensors: motion capture and IMU."""
