"""The firmware's controllers at 500 Hz: Mellinger, and the PID cascade."""
