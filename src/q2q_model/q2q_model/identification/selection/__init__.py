"""Model selection by error on held-out flights."""
