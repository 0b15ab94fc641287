"""Command lines: what a user types, parsed and refused before anything heavy is imported."""
