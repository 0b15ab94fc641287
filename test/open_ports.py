"""The addresses that a port is bound to, as the kernel lists them."""

import socket
from pathlib import Path


def addresses_of(protocol: str, port: int) -> set[str]:
    """Return the local addresses of the sockets on a port; `protocol` is tcp, tcp6, udp or udp6."""
    rows = Path(f"/proc/net/{protocol}").read_text().splitlines()[1:]
    local = (row.split()[1].split(":") for row in rows)
    return {_readable(address) for address, number in local if int(number, 16) == port}


def _readable(address: str) -> str:
    """Return an address of hexadecimal words of four bytes, each in the machine's order."""
    words = bytes.fromhex(address)
    data = b"".join(words[at : at + 4][::-1] for at in range(0, len(words), 4))
    return socket.inet_ntop(socket.AF_INET if len(data) == 4 else socket.AF_INET6, data)
