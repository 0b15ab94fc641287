"""Preloading of all code of a flight's nodes, for the fork server (q2q_sim.processes.fork_server).

A few ticks of flight without ROS load the compiled code of every block. All objects are then frozen: the
garbage collectors of forks skip them, so their memory stays shared.
"""

import gc
import sys
from dataclasses import replace
from importlib import import_module

from q2q_model.node.lean_imports import lean_imports
from q2q_sim.processes.fork_server import say_in_a_line
from q2q_sim.processes.parent_death import die_with_parent
from q2q_sim.scenarios.choices import CONTROLLERS

NODES = ("bag_play_node", "bag_record_node", "simulator_node", "stack")
"""Modules that import every node of a flight."""
SCENARIO = "table6"
WARM_UP_S = 0.05
"""Length of the flight [s]: every block's first ticks."""


def warm_up() -> None:
    """Fly a few ticks with each controller."""
    from q2q_model.model_files.find_model import find_model
    from q2q_sim.loop.closed_loop import FlightOptions, fly
    from q2q_sim.scenarios import library

    short = replace(library.load(SCENARIO), duration=WARM_UP_S)
    for controller in CONTROLLERS:
        fly(short, FlightOptions(controller=controller, model=find_model(short.model).interaction))


die_with_parent()
sys.excepthook = say_in_a_line
with lean_imports():
    for name in NODES:
        import_module(f"q2q_sim.ros.{name}")
    warm_up()
gc.collect()
gc.freeze()
