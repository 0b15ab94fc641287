"""Command lines: options and their checks, before anything slow is imported."""
