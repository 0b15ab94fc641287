"""Failsafe: guard, ladder of fallbacks, blind flight, evasion."""
