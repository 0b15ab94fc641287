"""Vehicle constants with their sources, altitude loop, thrust map."""
