"""Names of vehicles, with which topics and files begin."""

import re

VEHICLE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}")
"""Names that can begin a topic (a token of ROS 2 topic names, of 247 characters) or the name of a file."""
LONGEST_SHOWN = 40
"""Most characters of a wrong name in a message."""


def check_vehicle_name(name: str) -> None:
    """Raise ValueError for a vehicle's name that cannot begin a topic."""
    if not VEHICLE_NAME.fullmatch(name):
        allowed = "a name must be a letter followed by letters, digits and _, at most 100"
        raise ValueError(f"vehicle {name[:LONGEST_SHOWN]!r}: {allowed}")


def is_printable_name(name: str) -> bool:
    """Return whether a name of motion capture can be read in a report: not blank, no line break."""
    return bool(name.strip()) and name.isprintable()
