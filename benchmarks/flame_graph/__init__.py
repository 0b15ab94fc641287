"""Flame graphs of sampled stacks."""
