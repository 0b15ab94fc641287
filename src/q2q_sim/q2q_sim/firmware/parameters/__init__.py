"""The firmware's parameters: names, types, values, what clients upload."""
