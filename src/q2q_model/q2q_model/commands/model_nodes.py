"""Entry points of the nodes; an interrupt during imports exits without a traceback."""

from q2q_model.commands.node_start import start_node


def mocap_filter() -> None:
    """Run the node `mocap_filter`."""
    start_node("q2q_model.ros.mocap_filter_node")


def interference() -> None:
    """Run the node `interference`."""
    start_node("q2q_model.ros.interference_node")
