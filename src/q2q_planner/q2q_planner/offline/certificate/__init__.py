"""Proof for all times: polynomials bounded piece by piece, rounding included, outside a convex zone."""
