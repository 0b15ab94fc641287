"""Minimum snap trajectories (17): waypoints in, polynomials within the flight limits out."""
