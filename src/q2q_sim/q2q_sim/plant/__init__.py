"""Simulated vehicles and air, in compiled loops."""
