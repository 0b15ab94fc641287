"""Gains of the closed altitude loop, sections 2.2 and 3.2, and thrust lag."""
