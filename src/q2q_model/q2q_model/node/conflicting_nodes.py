"""Other nodes that publish what a node publishes."""

from collections.abc import Sequence


def conflicting_nodes(node: str, publishers: Sequence[Sequence[str]]) -> str:
    """Return the names of other nodes that publish the same topics; empty if there are none.

    Args:
        node: name of this node, which publishes each topic once.
        publishers: the publishing nodes of each topic.
    """
    found = {name for names in publishers for name in names}
    same_name = {node} if max(map(len, publishers), default=0) > 1 and found <= {node} else set()
    return ", ".join(sorted((found - {node}) | same_name))
