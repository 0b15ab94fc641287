"""Build of a vehicle's firmware, and its decks."""

from dataclasses import dataclass, field

from q2q_sim.sensors.range_finder import RoomBox

SEES_FLOW = frozenset(("bcFlow", "bcFlow2"))
"""Decks that see the ground move."""
LOOKS_DOWN = SEES_FLOW | {"bcZRanger", "bcZRanger2"}
"""Decks that measure the range downwards."""
LOOKS_AROUND = "bcMultiranger"
"""Deck that measures the other ranges."""


@dataclass(frozen=True, slots=True)
class Build:
    """Build options of the firmware and equipment of the vehicle."""

    auto_arming: bool = True
    """False: CONFIG_MOTORS_REQUIRE_ARMING."""
    number: int = 0
    """Index of the vehicle in the room: the last byte of its radio address."""
    positioning_deck: bool = True
    """The vehicle measures its position, as with a Lighthouse deck; else clients send it."""
    flow_deck: bool = False
    """Without a positioning deck: it measures velocity and height, relative to the initial estimate."""
    decks: tuple[str, ...] = ()
    """Decks reported to clients (parameter_table.DECKS)."""
    room: RoomBox = field(default_factory=RoomBox)
    """What the range finders see."""
    zero_expires: bool = False
    """Unlike the firmware: a client's setpoint without thrust expires after ZERO_EXPIRES_MS."""
