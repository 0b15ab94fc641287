"""Fly a scenario in the simulator: ros2 launch q2q_sim scenario.launch.py scenario:=table6 foxglove:=true."""

from launch import LaunchDescription
from q2q_sim.launching.launch_arguments import SCENARIO_ARGUMENTS
from q2q_sim.launching.launch_description import describe_launch
from q2q_sim.launching.launched_nodes import scenario_nodes


def generate_launch_description() -> LaunchDescription:
    """Return the simulator's room and the nodes that fly in it; `--show-args` lists the arguments."""
    return describe_launch(SCENARIO_ARGUMENTS, scenario_nodes)
