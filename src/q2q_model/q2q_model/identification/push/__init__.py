"""Vertical push of the downwash measured in flight, and the checks of its sensors and logs."""
