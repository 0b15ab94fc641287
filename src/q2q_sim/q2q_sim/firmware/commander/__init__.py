"""The firmware's commander and high-level planner."""
