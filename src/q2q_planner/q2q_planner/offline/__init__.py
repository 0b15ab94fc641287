"""Offline planning: minimum snap, joint avoidance of the downwash zone, certificate."""
