"""Whether a recorded topic was latched: its publishers offered late subscribers the last message.

Every recorder since ROS 2 Foxy stores the qualities of service that a topic's publishers offered, as YAML
with names (`durability: transient_local`) or, until ROS 2 Iron, with numbers (`durability: 1`).
"""

import re
from collections.abc import Mapping

from rosbags.interfaces import Connection, ConnectionExtRosbag2, QosDurability

OFFERED = "offered_qos_profiles"
"""Key of the offered qualities of service in the metadata of an MCAP channel."""
LATCHED = {"transient_local", "1"}
_DURABILITY = re.compile(r"\bdurability: *(\w+)")


def channel_is_latched(metadata: Mapping[str, str]) -> bool:
    """Return whether all publishers of an MCAP channel latched it, by the channel's metadata."""
    found = set(_DURABILITY.findall(metadata.get(OFFERED, "")))
    return bool(found) and found <= LATCHED


def connection_is_latched(connection: Connection) -> bool:
    """Return whether all publishers of a connection of a rosbag2 bag latched it."""
    if not isinstance(connection.ext, ConnectionExtRosbag2):
        return False
    offered = {one.durability for one in connection.ext.offered_qos_profiles}
    return offered == {QosDurability.TRANSIENT_LOCAL}
