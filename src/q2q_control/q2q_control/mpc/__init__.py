"""Model predictive control: the problem, its solver, and what they need to know, a file each."""
