"""Nodes are named once the middleware knows their names."""

from q2q_model.node.node_names import NAMELESS, UNKNOWN_NAME, full_node_names


def test_a_node_that_is_being_discovered_counts_without_its_name() -> None:
    undiscovered = ("_NODE_NAMESPACE_UNKNOWN_", UNKNOWN_NAME)
    nodes = [("/", "pid"), undiscovered, ("/room/a", "mpc"), undiscovered, ("/", "pid")]
    assert full_node_names(nodes) == [NAMELESS, NAMELESS, "pid", "pid", "room/a/mpc"]
