"""UDP ports of vehicles, one for each, on loopback only."""

import socket
from collections.abc import Sequence
from dataclasses import dataclass

from q2q_model.node.loopback import LOOPBACK
from q2q_model.tunable import check_bounds, tunable

LAST_PORT = 65535


@dataclass(frozen=True, slots=True)
class PortParams:
    """Ports of an endpoint."""

    port: int = tunable(
        19850, "UDP port of the first vehicle; 0 lets the system choose", low=0, high=LAST_PORT
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def opened_ports(names: Sequence[str], base_port: int) -> list[socket.socket]:
    """Return the sockets of vehicles on base_port, base_port + 1, ...; with 0 the system chooses each.

    Raises:
        ValueError: there are not as many ports from base_port on.
        OSError: a port is taken, naming it.
    """
    last = LAST_PORT + 1 - len(names)
    if base_port > last:
        raise ValueError(f"port {base_port}; must be in [0, {last}] for {len(names)} vehicles")
    opened: list[socket.socket] = []
    try:
        for row, name in enumerate(names):
            opened.append(_open(name, base_port + row if base_port else 0))
    except OSError:
        for one in opened:
            one.close()
        raise
    return opened


def _open(name: str, port: int) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.settimeout(0.0)
    try:
        made.bind((LOOPBACK, port))
    except OSError as refusal:
        made.close()
        raise OSError(
            f"UDP port {port} of {name} is taken on {LOOPBACK} ({refusal.strerror}): choose another crtp_port"
        ) from refusal
    return made
