"""Terms of an air model learned from recorded flights, one file per term."""
