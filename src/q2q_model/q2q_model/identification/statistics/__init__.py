"""Confidence intervals of identified parameters."""
