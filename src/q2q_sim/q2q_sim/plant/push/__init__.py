"""Acceleration of every vehicle by the air: pairs of vehicles and jets, and their sum."""
