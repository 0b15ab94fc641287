"""Failsafe: guard, fallback phases, flight without measurements, evasion."""
