"""Nodes are named once the middleware knows their names."""

from q2q_model.node.node_names import UNKNOWN_NAME, full_node_names


def test_a_node_that_is_being_discovered_is_left_out() -> None:
    undiscovered = ("_NODE_NAMESPACE_UNKNOWN_", UNKNOWN_NAME)
    nodes = [("/", "pid"), undiscovered, ("/room/a", "mpc"), undiscovered, ("/", "pid")]
    assert full_node_names(nodes) == ["pid", "pid", "room/a/mpc"]
