"""Inputs of a controller: aligned signals, preview of the reference."""
