"""Flame graph as SVG (Gregg, The flame graph, CACM 2016): width is time, a row lies on the one that calls it.

Order from left to right means nothing: functions of one caller are sorted by name. Where the pointer rests,
a box shows function and share. Boxes below LEAST of the whole are left out.
"""

from collections.abc import Iterator
from typing import NamedTuple
from xml.sax.saxutils import escape

from flame_graph.frame_tree import Frame
from q2q_model import palette

WIDTH, ROW, LETTER = 1200.0, 17.0, 6.6
"""Of the picture, height of a row, width of a letter [pixel]."""
LEAST = 0.002
"""Smallest share of a box [-]."""
COLOURS = {
    "q2q_model": palette.SKY,
    "q2q_planner": palette.PURPLE,
    "q2q_control": palette.ORANGE,
    "q2q_sim": palette.GREEN,
    "rclpy": palette.YELLOW,
}
"""Of the packages."""
OTHERS = "#c8c8c8"


class Box(NamedTuple):
    """Frame on the picture."""

    name: str
    share: float
    """Of all samples [-]."""
    left: float
    """Share of the width left of it [-]."""
    level: int
    """Calls around it."""


def boxes(frame: Frame, whole: int, left: float = 0.0, level: int = 0) -> Iterator[Box]:
    """Yield the boxes of a frame and of its calls, of `whole` samples in all."""
    share = frame.samples / whole
    if share < LEAST:
        return
    yield Box(frame.name, share, left, level)
    for name in sorted(frame.calls):
        yield from boxes(frame.calls[name], whole, left, level + 1)
        left += frame.calls[name].samples / whole


def flame_graph(tree: Frame, title: str) -> str:
    """Return the SVG of a tree."""
    drawn = list(boxes(tree, tree.samples))
    height = ROW * (3 + max(box.level for box in drawn))
    font = 'font-family="monospace" font-size="11"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {height:g}" {font}>',
        "<style>g rect { stroke: white; stroke-width: 0.5 }</style>",
        f'<rect width="100%" height="100%" fill="white"/><text x="4" y="13">{escape(title)}</text>',
    ]
    parts += list(_legend())
    parts += [_drawn(box, height) for box in drawn]
    return "\n".join([*parts, "</svg>\n"])


def _legend() -> Iterator[str]:
    x = WIDTH
    for name, colour in {**COLOURS, "other": OTHERS}.items():
        x -= LETTER * (len(name) + 3)
        yield f'<rect x="{x:.0f}" y="4" width="9" height="9" fill="{colour}"/>'
        yield f'<text x="{x + 12:.0f}" y="13">{name}</text>'


def _drawn(box: Box, height: float) -> str:
    x, width, y = WIDTH * box.left, WIDTH * box.share, height - ROW * (box.level + 1)
    letters = int((width - 4) / LETTER)
    short = box.name.partition(" (")[0]
    text = short if len(short) <= letters else short[: letters - 1] + "…" if letters > 3 else ""
    name = f'<text x="{x + 2:.1f}" y="{y + 12:.0f}">{escape(text)}</text>' if text else ""
    return (
        f"<g><title>{escape(box.name)}: {100 * box.share:.1f} %</title>"
        f'<rect x="{x:.1f}" y="{y:.0f}" width="{width:.1f}" height="{ROW - 1:g}" fill="{_colour(box.name)}"/>'
        f"{name}</g>"
    )


def _colour(name: str) -> str:
    """Return the colour of a frame's package."""
    _, _, place = name.partition(" (")
    return next((colour for package, colour in COLOURS.items() if place.startswith(package)), OTHERS)
