"""Names of the nodes at the other end of a topic, as the middleware knows them."""

from collections.abc import Iterable

UNKNOWN_NAME = "_NODE_NAME_UNKNOWN_"
"""Name of a node that is being discovered, or has left while its publishers still count (rmw_fastrtps)."""


def full_node_names(nodes: Iterable[tuple[str, str]]) -> list[str]:
    """Return the full names of nodes given by namespace and name, sorted, without those that are unknown."""
    return sorted(f"{namespace}/{name}".strip("/") for namespace, name in nodes if name != UNKNOWN_NAME)
