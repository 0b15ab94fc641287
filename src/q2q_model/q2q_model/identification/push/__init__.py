"""Vertical push of the downwash measured in flight, and the jet fitted to it."""
