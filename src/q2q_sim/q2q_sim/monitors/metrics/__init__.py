"""Measures of a flight: errors and effort, distances between vehicles, time in each other's downwash."""
