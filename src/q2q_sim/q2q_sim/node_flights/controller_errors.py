"""Errors of a user's controller in a live flight, which the node logs while the failsafe flies."""

from pathlib import Path

from q2q_sim.scenarios.choices import OWN_CONTROLLER


def controller_errors(folder: Path) -> list[str]:
    """Return the errors in the logs of a flight's nodes, in order, each once."""
    begin = f" [{OWN_CONTROLLER}]: "
    logs = [one.read_text(encoding="utf-8", errors="replace") for one in sorted(folder.glob("*.log"))]
    lines = [line for log in logs for line in log.splitlines() if line.startswith("[ERROR]")]
    return list(dict.fromkeys(line.partition(begin)[2] for line in lines if begin in line))
