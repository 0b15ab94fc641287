"""Import and rehearse all that the nodes of a flight need: what q2q_sim.tools.warm_start has its parent do.

Some ticks of a short flight, without ROS, load the compiled code of every block. What stands then is frozen:
no fork's garbage collector looks at it, so its memory stays shared.
"""

import gc
from dataclasses import replace
from importlib import import_module

from q2q_model.lean_imports import lean_imports
from q2q_sim.choices import CONTROLLERS
from q2q_sim.tools.warm_start import die_with_parent

NODES = ("bag_play_node", "bag_record_node", "simulator_node", "stack")
"""Modules that import every node of a flight."""
SCENARIO = "table6"
REHEARSED_S = 0.05
"""Length of the flight [s]: every block's first ticks."""


def rehearse() -> None:
    """Fly some ticks with each controller."""
    from q2q_model.tools.models import find_model
    from q2q_sim import scenarios
    from q2q_sim.closed_loop import FlightOptions, fly

    short = replace(scenarios.load(SCENARIO), duration=REHEARSED_S)
    for controller in CONTROLLERS:
        fly(short, FlightOptions(controller=controller, model=find_model(short.model).interaction))


die_with_parent()
with lean_imports():
    for name in NODES:
        import_module(f"q2q_sim.ros.{name}")
    rehearse()
gc.collect()
gc.freeze()
