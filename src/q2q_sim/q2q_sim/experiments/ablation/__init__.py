"""Ablation: controllers with and without knowledge of the downwash."""
