"""Explicit MPC: a linear law and a neural network distilled from the MPC, and their export to C99."""
