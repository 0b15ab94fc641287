"""Push of the air on every vehicle: who is in whose jet, and by how much it is accelerated."""
