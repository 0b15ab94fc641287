"""What a URI of cflib reaches: one vehicle has many spellings of its URI.

By cflib 0.1.34 (crtp/radiodriver.py, parse_uri; crtp/udpdriver.py, connect):

| URI | reaches the vehicle at |
|---|---|
| radio://DONGLE/CHANNEL/RATE/ADDRESS?QUERY | channel, rate (default 2M), address (default E7E7E7E7E7) |
| udp://HOST:PORT/PATH?QUERY | IPv4 address of the host, port |
"""

from socket import gethostbyname
from urllib.parse import urlsplit

RATES = ("250K", "1M", "2M")
"""Data rates of the radio; any other word is the last."""
ADDRESS = "E7E7E7E7E7"
"""Address of a vehicle as it is delivered, in hexadecimal."""


def canonical_uri(uri: str) -> str:
    """Return one spelling of the URIs that reach the same vehicle, in lower case if it is not known how."""
    try:
        parts = urlsplit(uri)
        if parts.scheme == "radio":
            return _radio(*parts.path.strip("/").split("/")[:3])
        if parts.scheme == "udp" and parts.hostname:
            return f"udp://{gethostbyname(parts.hostname)}:{parts.port}"
    except (ValueError, OSError):  # no channel, no port, a host of no address: the link says what is wrong
        pass
    return uri.lower()


def _radio(channel: str, rate: str = RATES[-1], address: str = ADDRESS) -> str:
    """Return the URI of a vehicle on the radio; of an address, leading zeros may be left out."""
    known = rate if rate in RATES else RATES[-1]
    return f"radio://*/{int(channel)}/{known}/{address.upper():0>10}"
