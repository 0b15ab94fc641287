"""Failsafe: guard, ladder of fallbacks, dead-reckoned braking, descent evasion."""
