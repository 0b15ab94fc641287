"""The safe replanner: one motion per vehicle, proven in every tick to stay out of the zones of all others."""
