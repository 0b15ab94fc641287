"""Exclusive use of something by one program of a machine, as of a link to a vehicle: its claim.

A socket in Linux's abstract namespace holds it (unix(7)): it leaves no file, and ends with its process.
Programs in other network namespaces, as containers without the host's network, are not seen.
"""

from hashlib import blake2b
from socket import AF_UNIX, SOCK_DGRAM, socket


def claim(what: str) -> socket:
    """Return the claim of something, which ends when it is closed.

    Raises:
        ValueError: it is claimed already.
    """
    held = socket(AF_UNIX, SOCK_DGRAM)
    try:
        held.bind(f"\0q2q {blake2b(what.encode(), digest_size=16).hexdigest()}")
    except OSError as taken:
        held.close()
        raise ValueError(f"{what} is in use by another node on this machine: end that one first") from taken
    return held
