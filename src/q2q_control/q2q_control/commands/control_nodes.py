"""Entry points of the package's nodes; an interrupt during their import ends them quietly."""

from q2q_control.flight_procedure.procedure_params import DRY_RUN
from q2q_model.commands.node_start import start_node


def pid() -> None:
    """Run the node `pid`."""
    start_node("q2q_control.ros.pid_node")


def mpc() -> None:
    """Run the node `mpc`."""
    start_node("q2q_control.ros.mpc_node")


def own_controller() -> None:
    """Run the node `own_controller`."""
    start_node("q2q_control.ros.own_controller_node")


def crazyswarm() -> None:
    """Run the node `crazyswarm`."""
    start_node("q2q_control.ros.crazyswarm_node", {"dry_run": DRY_RUN})


def radio() -> None:
    """Run the node `radio`."""
    start_node("q2q_control.ros.radio_node", {"dry_run": DRY_RUN})
