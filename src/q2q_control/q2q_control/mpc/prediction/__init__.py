"""Predictions along the horizon: vehicles, references and downwash."""
