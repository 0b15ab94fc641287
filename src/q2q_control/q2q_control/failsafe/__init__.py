"""Failsafe: guard, fallback phases, dead reckoning of vehicles that are not tracked, evasion."""
