"""App for the vehicle's own firmware, in C99: downwash, its correction, and an explicit law."""
