"""Inputs of the policies: the trace of a flight, its circumstances, and limits."""
