"""Whether a flight has its positions in metres, z up and its vehicles upright."""
