"""Model files: format, names, lookup."""
