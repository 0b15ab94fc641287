"""Signals: the values that pass between blocks, their layout, bytes and tick join."""
