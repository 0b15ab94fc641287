"""Entry points of the package's nodes; an interrupt during import ends them quietly."""

from q2q_model.commands.node_start import start_node


def simulator() -> None:
    """Run the node `simulator`."""
    start_node("q2q_sim.ros.simulator_node")


def bag_record() -> None:
    """Run the node `bag_record`."""
    start_node("q2q_sim.ros.bag_record_node")


def bag_play() -> None:
    """Run the node `bag_play`."""
    start_node("q2q_sim.ros.bag_play_node")


def stack() -> None:
    """Run the process `stack`."""
    start_node("q2q_sim.ros.stack")


def view() -> None:
    """Run the node `view`."""
    start_node("q2q_sim.ros.view_node")
