"""Fly Crazyflies in a real room: ros2 launch q2q_sim real_room.launch.py plan:=FILE crazyflies:=FILE.

Another node must publish motion capture on the topic `mocap:=`. No vehicle moves before `/radio/take_off` is
called.
"""

from launch import LaunchDescription
from q2q_sim.launching.launch_arguments import ROOM_ARGUMENTS
from q2q_sim.launching.launch_description import describe_launch
from q2q_sim.launching.launched_nodes import room_nodes


def generate_launch_description() -> LaunchDescription:
    """Return the nodes between motion capture and radio; `--show-args` lists the arguments."""
    return describe_launch(ROOM_ARGUMENTS, room_nodes, {"mocap": "mocap"})
