"""Motors, battery and airframe."""
