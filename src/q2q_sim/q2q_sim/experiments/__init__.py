"""Experiments: campaigns, the ablation, the paper's tables and figures."""
