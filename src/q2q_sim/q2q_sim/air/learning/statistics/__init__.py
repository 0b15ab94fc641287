"""Intervals of what is learned from recorded flights: bootstrap over blocks, autocovariance."""
