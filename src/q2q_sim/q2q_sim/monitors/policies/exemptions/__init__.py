"""Vehicles that a policy does not judge, or judges less strictly, and why."""
