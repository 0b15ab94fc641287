"""State machine of a flight procedure: the ends of its steps, the outcomes of orders, and their executors."""
