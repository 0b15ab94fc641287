"""Jet of one source: its table, how its air travels, and the rows of recorded flights under it."""
