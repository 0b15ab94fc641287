"""Attitude tracks of the mocap filter."""
