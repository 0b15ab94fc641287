"""Flight procedure of real vehicles: checks, take-off, flight, landing."""
