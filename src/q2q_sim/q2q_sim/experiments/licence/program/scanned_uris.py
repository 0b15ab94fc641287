"""URIs that a scan for vehicles answers."""

SCANNED = "radio://0/80/2M/E7E7E7E7"
"""Before the last byte of the address."""


def scanned_uris(count: int) -> tuple[str, ...]:
    """Return the URIs of `count` vehicles that a scan answers: the factory's address, then 01, 02, ..."""
    return (f"{SCANNED}E7",) if count == 1 else tuple(f"{SCANNED}{k + 1:02X}" for k in range(count))
