"""Bag of a flight: topics, which are recorded, facts of its scenario; its trace, verdict and diagnostics."""
