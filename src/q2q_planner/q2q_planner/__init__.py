"""Trajectory planning: minimum snap, avoidance of interaction zones, online replanner."""
