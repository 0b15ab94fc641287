"""Recorded flights with their logs, read from bags and tables."""
