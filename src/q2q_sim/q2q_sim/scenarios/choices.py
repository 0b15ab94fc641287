"""Name what a user may choose between; the code behind it is elsewhere, and imports more."""

CONTROLLERS = ("pid", "mpc")
"""Who computes commands (q2q_sim.loop.assembly)."""
REPLANNERS = ("none", "paper", "safe")
"""Laws of the online replanner (q2q_sim.loop.assembly)."""
WAKES = ("none", "paper", "measured")
"""Airs of the simulator (q2q_sim.plant.wake)."""
ENGINES = ("local", "dask")
"""Who runs a campaign's flights at once (q2q_sim.experiments.campaign.engine)."""
TABLE_ONLY = "--table-only"
"""Option of the ablation that flies nothing."""
STDOUT = "-"
"""File name that means standard output."""
