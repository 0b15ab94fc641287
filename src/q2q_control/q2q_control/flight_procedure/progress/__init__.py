"""Progress of a flight: its step, what ends a step, and what follows the outcome of an order."""
