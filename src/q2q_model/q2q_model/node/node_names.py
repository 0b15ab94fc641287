"""Names of the nodes at the other end of a topic, as the middleware knows them."""

from collections.abc import Iterable

UNKNOWN_NAME = "_NODE_NAME_UNKNOWN_"
"""Name of a node that is being discovered, or has left while its publishers still count (rmw_fastrtps)."""

NAMELESS = "one whose name is not known"


def full_node_names(nodes: Iterable[tuple[str, str]]) -> list[str]:
    """Return the full names of nodes given by namespace and name, sorted; NAMELESS for those without one."""
    return sorted(
        NAMELESS if name == UNKNOWN_NAME else f"{namespace}/{name}".strip("/") for namespace, name in nodes
    )
