"""Choices of the command lines, apart from the code behind them, which imports more."""

from q2q_sim.air.air_names import LAWS

CONTROLLERS = ("pid", "mpc")
"""Controllers (q2q_sim.loop.flight_blocks)."""
REPLANNERS = ("none", "paper", "safe")
"""Online replanners (q2q_sim.loop.flight_blocks)."""
WAKES = LAWS
"""True wakes of the simulator (q2q_sim.air.wake_laws)."""
AIR_TERMS = (
    "jet",
    "absorption",
    "meander",
    "residual",
    "edge_torque",
    "ground",
    "wind",
    "vehicle",
    "rotor_drag",
    "rate_load",
)
"""Terms of an air (q2q_sim.air.room_air)."""
TOPICS = (
    "mocap",
    "truth",
    "truth_interference",
    "imu",
    "state",
    "reference",
    "reference_safe",
    "interference",
    "command",
)
"""Topics of every tick, which a bag may hold (q2q_sim.flight_bag.topics)."""
DISTRIBUTED_TOPIC = "predictions"
"""Topic that a bag may hold of a distributed flight only (q2q_model.signals.topic_names)."""
ENGINES = ("local", "dask")
"""Engines that run a campaign in parallel (q2q_sim.processes.parallel_work)."""
TABLE_ONLY = "--table-only"
"""Option of the ablation that only writes the table."""
