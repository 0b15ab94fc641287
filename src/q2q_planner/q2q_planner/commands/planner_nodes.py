"""Entry points of the package's nodes; an interrupt during their import ends them quietly."""

from q2q_model.commands.node_start import start_node


def trajectory() -> None:
    """Run the node `trajectory`."""
    start_node("q2q_planner.ros.trajectory_node")


def replanner() -> None:
    """Run the node `replanner`."""
    start_node("q2q_planner.ros.replanner_node")
