"""Training of the paper's envelope networks (15), (16)."""
