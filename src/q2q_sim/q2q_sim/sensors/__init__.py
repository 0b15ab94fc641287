"""Simulated sensors: motion capture, IMU and range finders."""
