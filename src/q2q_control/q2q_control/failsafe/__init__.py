"""Failsafe: guard, fallback phases, blind flight, evasion."""
