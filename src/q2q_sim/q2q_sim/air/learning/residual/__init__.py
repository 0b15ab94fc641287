"""Turbulence under a wake: what a jet leaves, its process, and how the gains of vehicles differ."""
