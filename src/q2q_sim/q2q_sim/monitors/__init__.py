"""Monitors: metrics, safety policies, verdict of a flight."""
