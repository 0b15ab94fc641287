"""Model predictive control: the problem, what is predicted for it, its solver, and the commands of a tick."""
