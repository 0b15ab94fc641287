"""Publishers of Crazyswarm2's setpoints: `<name>/cmd_full_state` or `<name>/cmd_vel_legacy`."""

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node
from std_msgs.msg import Header

from q2q_control.crazyswarm.message_conversion import legacy_twists
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.radio.link.setpoints import FullState, full_states
from q2q_control.ros.crazyswarm_types import CRAZYFLIE_PACKAGE, find_types
from q2q_model.node.connections import conflicting_nodes
from q2q_model.ros.node.publisher_conflicts import publishers_of
from q2q_model.ros.topics.messages import header_at, pose_message
from q2q_model.signals.values import Interference, Names, SwarmCommand, SwarmSetpoint

QUEUE = 1
"""Depth of a queue: a setpoint not sent in time is replaced by the next."""
FULL_STATE, LEGACY = "cmd_full_state", "cmd_vel_legacy"
"""Topics below a vehicle's name; Crazyswarm2's server sends what comes on either."""


class CrazyswarmCommands:
    """Setpoint publishers of all vehicles."""

    def __init__(self, node: Node, names: Names, legacy: tuple[RpytScale, str], *, full_state: bool) -> None:
        """Create publishers of full states, or of RPYT setpoints in a scale for a backend.

        Raises:
            ImportError: `full_state`, and the package of its message is missing.
        """
        self._node, self._legacy = node, legacy
        self._full_state = find_types(CRAZYFLIE_PACKAGE, ("FullState",))[0] if full_state else Twist
        topic = FULL_STATE if full_state else LEGACY
        self._writers = {
            name: node.create_publisher(self._full_state, f"{name}/{topic}", QUEUE) for name in names
        }

    def conflicts(self) -> str:
        """Return which other nodes publish setpoints of these vehicles, and what to do; empty if none do."""
        topics = [f"{name}/{topic}" for name in self._writers for topic in (FULL_STATE, LEGACY)]
        writers = [publishers_of(self._node, topic) for topic in topics]
        others = conflicting_nodes(self._node.get_fully_qualified_name().strip("/"), writers)
        advice = "stop them, or set legacy_hz:=0 on a controller"
        return f"other nodes publish setpoints of these vehicles ({others}): {advice}" if others else ""

    def send_setpoint(self, stamp_ns: int, setpoint: SwarmSetpoint, downwash: Interference | None) -> Names:
        """Publish every known vehicle's full state, if it is finite; return whose were."""
        rows = zip(setpoint.names, full_states(setpoint, downwash), strict=True)
        sent = {name: one for name, one in rows if one is not None and name in self._writers}
        header = header_at(stamp_ns)
        for name, full_state in sent.items():
            self._writers[name].publish(self._message(header, full_state))
        return tuple(sent)

    def send_command(self, command: SwarmCommand) -> Names:
        """Publish every known vehicle's RPYT setpoint, if it is finite; return whose were."""
        rows = zip(command.names, legacy_twists(command, *self._legacy), strict=True)
        sent = {name: row for name, row in rows if name in self._writers and np.isfinite(row).all()}
        for name, row in sent.items():
            x, y, yaw_rate, pwm = row.tolist()
            self._writers[name].publish(Twist(linear=Vector3(x=x, y=y, z=pwm), angular=Vector3(z=yaw_rate)))
        return tuple(sent)

    def unlock(self) -> None:
        """Publish every vehicle's RPYT setpoint of thrust 0."""
        for writer in self._writers.values():
            writer.publish(Twist())

    def _message(self, header: Header, full_state: FullState) -> object:
        pose = pose_message(full_state.pos, full_state.quat)
        twist = Twist(linear=_vector(full_state.vel), angular=_vector(full_state.ang_vel))
        return self._full_state(header=header, pose=pose, twist=twist, acc=_vector(full_state.acc))


def _vector(values: tuple[float, ...]) -> Vector3:
    x, y, z = values
    return Vector3(x=x, y=y, z=z)
