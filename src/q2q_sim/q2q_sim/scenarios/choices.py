"""Choices of the command lines, apart from the code behind them, which imports more."""

from q2q_model.own_class import is_own_class
from q2q_sim.air.air_names import LAWS

CONTROLLERS = ("pid", "mpc")
"""Controllers (q2q_sim.loop.flight_blocks)."""
OWN_CONTROLLER = "own_controller"
"""Node that runs a user's controller."""
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


def check_controller(name: str, *, correct: bool, limit: bool) -> None:
    """Raise ValueError for no controller, or choices that a user's does not know; it is not imported."""
    if name not in CONTROLLERS and not is_own_class(name):
        raise ValueError(
            f"unknown controller {name!r}: choose one of {', '.join(CONTROLLERS)}, or give your own as "
            "module:Class"
        )
    for given, what in ((correct, "correct"), (not limit, "no limit of thrust")):
        if given and name not in CONTROLLERS:
            raise ValueError(f"controller {name} with {what}: only for {' and '.join(CONTROLLERS)}")
