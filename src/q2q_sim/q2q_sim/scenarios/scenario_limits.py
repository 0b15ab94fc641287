"""Limits of a scenario: its duration and the size of a swarm."""

SHORTEST, LONGEST = 0.01, 3600.0
"""Shortest flight, one tick, and longest [s]."""
MOST_VEHICLES = 1000
"""Largest swarm; its room is 100 m wide."""
