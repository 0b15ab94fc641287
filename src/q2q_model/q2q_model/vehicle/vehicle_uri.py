"""What a URI of cflib reaches: one vehicle has many spellings of its URI.

By cflib 0.1.34 (crtp/radiodriver.py, parse_uri; crtp/udpdriver.py, connect):

| URI | reaches the vehicle at |
|---|---|
| radio://DONGLE/CHANNEL/RATE/ADDRESS?QUERY | channel, rate (default 2M), address (default E7E7E7E7E7) |
| udp://HOST:PORT/PATH?QUERY | IPv4 address of the host, port |

The address of a host is looked up when a link is opened, not when a file of vehicles is read.
"""

from socket import gethostbyname
from urllib.parse import urlsplit

RATES = ("250K", "1M", "2M")
"""Data rates of the radio; any other word is the last."""
ADDRESSES = {"localhost": "127.0.0.1"}
"""Addresses of hosts that are known without a look-up."""
ADDRESS = "E7E7E7E7E7"
"""Address of a vehicle as it is delivered, in hexadecimal."""


def canonical_uri(uri: str) -> str:
    """Return one spelling of the URIs that reach the same vehicle, in lower case if it is not known how."""
    try:
        parts = urlsplit(uri)
        if parts.scheme == "radio":
            return _radio(*parts.path.strip("/").split("/")[:3])
        if parts.scheme == "udp" and parts.hostname:
            return f"udp://{ADDRESSES.get(parts.hostname, parts.hostname)}:{parts.port}"
    except ValueError:  # no channel, no port: the link says what is wrong
        pass
    return uri.lower()


def resolved_uri(uri: str) -> str:
    """Return the canonical URI with the address of a host: without a network, to look it up takes seconds."""
    canonical = canonical_uri(uri)
    try:
        parts = urlsplit(canonical)
        if parts.scheme == "udp" and parts.hostname:
            return f"udp://{gethostbyname(parts.hostname)}:{parts.port}"
    except (ValueError, OSError):  # no port, a host of no address: the link says what is wrong
        pass
    return canonical


def _radio(channel: str, rate: str = RATES[-1], address: str = ADDRESS) -> str:
    """Return the URI of a vehicle on the radio; of an address, leading zeros may be left out."""
    known = rate if rate in RATES else RATES[-1]
    return f"radio://*/{int(channel)}/{known}/{address.upper():0>10}"
