"""Problem (26) solved once, over the whole flight: the references of the receding horizon."""
