"""App for the vehicle's own firmware, in C99: neighbours' tracks, their downwash, and its correction."""
