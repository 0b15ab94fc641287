"""Experiments: the ablation, the paper's tables and figures, and other studies of flights."""
