"""Model predictive control: prediction, the problem, its solver, and the commands of a tick."""
