"""Model predictive control: problem, predicted downwash and references, solver, commands of a tick."""
