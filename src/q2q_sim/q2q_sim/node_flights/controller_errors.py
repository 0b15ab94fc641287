"""Errors of a user's controller in a live flight, which the node logs while the failsafe flies."""

from pathlib import Path

from q2q_sim.node_flights.unfinished_bag import log_lines
from q2q_sim.scenarios.choices import OWN_CONTROLLER


def controller_errors(folder: Path) -> list[str]:
    """Return the errors in the logs of a flight's nodes, in order, each once."""
    begin = f" [{OWN_CONTROLLER}]: "
    errors = [line for line in log_lines(folder) if line.startswith("[ERROR]") and begin in line]
    return list(dict.fromkeys(line.partition(begin)[2] for line in errors))
