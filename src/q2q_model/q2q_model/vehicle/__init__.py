"""Vehicle constants with their sources, rigid-body dynamics, thrust map."""
