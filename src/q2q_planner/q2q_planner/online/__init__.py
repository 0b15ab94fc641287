"""Online replanners: planned setpoints in, setpoints outside the zones out."""
