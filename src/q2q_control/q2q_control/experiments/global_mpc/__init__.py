"""Problem (26) solved once over the whole flight, as a reference for the receding horizon."""
