"""Name what a user may choose between; the code behind it is elsewhere, and imports more."""

CONTROLLERS = ("pid", "mpc")
"""Who computes commands (q2q_sim.assembly)."""
REPLANNERS = ("none", "paper", "safe")
"""Laws of the online replanner (q2q_sim.assembly)."""
WAKES = ("none", "paper", "measured")
"""Airs of the simulator (q2q_sim.wake)."""
ENGINES = ("local", "dask")
"""Who runs a campaign's flights at once (q2q_sim.tools.campaign_engine)."""
TABLE_ONLY = "--table-only"
"""Option of the ablation that flies nothing."""
