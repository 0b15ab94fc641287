"""Terms of a room's air learned from its recorded flights, one file per term."""
