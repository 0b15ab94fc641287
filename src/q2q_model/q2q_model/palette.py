"""Colours of figures, pages and views, one meaning each: those of Okabe and Ito (2008).

People with any of the common colour blindnesses can distinguish them (Color Universal Design). A figure
distinguishes either flights or vehicles by colour, never both.
"""

BLACK, GREY = "#000000", "#6e6e6e"
ORANGE, SKY, GREEN, YELLOW = "#e69f00", "#56b4e9", "#009e73", "#f0e442"
BLUE, VERMILLION, PURPLE = "#0072b2", "#d55e00", "#cc79a7"

MEASURED = BLACK
"""What was recorded, or is true in the simulator."""
MODEL = BLUE
"""What a model predicts or simulates."""
REFERENCE = GREY
"""Reference or plan, dashed; also limits, dotted."""
WAKE = ORANGE
"""Time under another vehicle, as a band."""
ZONE = YELLOW
"""Inside of the zone to avoid, as an area."""
AIR, PUSH = SKY, VERMILLION
"""Air that rotors blow down; where it pushes a vehicle, its force, and a zone that a vehicle has entered."""
ROLL, PITCH = ORANGE, BLUE
FLIGHTS = (VERMILLION, GREEN, PURPLE, ORANGE)
"""Compared flights, repeated; in the demos the first ignores the downwash and the second is aware of it."""
VEHICLES = (BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION)
"""Vehicles of a flight, repeated."""


def rgba(colour: str, opacity: float = 1.0) -> tuple[float, float, float, float]:
    """Return red, green, blue and opacity, 0 to 1, of a colour `#rrggbb`."""
    red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue, opacity
