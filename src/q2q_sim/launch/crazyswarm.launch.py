"""Fly Crazyflies through Crazyswarm2: ros2 launch q2q_sim crazyswarm.launch.py plan:=FILE crazyflies:=FILE.

Starts Crazyswarm2's server (its own launch file, no GUI), the bridge and the nodes of q2q. With twin:=true
the server connects to the simulator, whose vehicles have the udp:// URIs of crazyflies.yaml. No vehicle moves
before `/crazyswarm/take_off` is called.
"""

from collections.abc import Mapping
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import SetRemap

from launch import LaunchDescription, LaunchDescriptionEntity
from q2q_sim.launching.launch_arguments import CRAZYSWARM_ARGUMENTS
from q2q_sim.launching.launch_description import describe_launch
from q2q_sim.launching.launched_nodes import crazyswarm_nodes, server_arguments


def server(given: Mapping[str, str]) -> list[LaunchDescriptionEntity]:
    """Return Crazyswarm2's own launch file; its server receives our filtered poses."""
    file = Path(get_package_share_directory("crazyflie"), "launch", "launch.py")
    included = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(file)), launch_arguments=list(server_arguments(given).items())
    )
    return [GroupAction([SetRemap("crazyflie_server:poses", "/poses_filtered"), included])]


def generate_launch_description() -> LaunchDescription:
    """Return server, bridge and nodes; `--show-args` lists the arguments."""
    return describe_launch(CRAZYSWARM_ARGUMENTS, crazyswarm_nodes, others=server)
