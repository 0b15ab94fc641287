"""Room of a licence: vehicles with their motion capture and faults, the log of a flight, and the flights."""
