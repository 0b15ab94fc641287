"""The safe replanner: one committed motion per vehicle, proven against everyone else's, every tick."""
