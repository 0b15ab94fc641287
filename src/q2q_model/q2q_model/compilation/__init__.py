"""Machine code of compiled functions: its dependencies, its cache, and the notice of a compilation."""
