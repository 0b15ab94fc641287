"""Geometry: rotations and the downwash zone."""
