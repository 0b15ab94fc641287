"""Command lines, parsed and checked before any slow import."""
