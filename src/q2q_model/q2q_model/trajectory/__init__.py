"""Piecewise polynomial trajectories: evaluation, files, energy, bounds, flatness."""
