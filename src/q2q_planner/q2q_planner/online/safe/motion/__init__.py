"""Motions of all vehicles at a tick: their bounds, the committed ones, what they follow, and traffic."""
