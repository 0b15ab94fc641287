"""Plain shapes of a scene: boxes, cylinders, arrows, lines, texts."""

import math
from dataclasses import dataclass
from enum import IntEnum

from q2q_model.signals.values import Names, Three

Colour = tuple[float, float, float, float]
"""Red, green, blue, opacity, 0 to 1."""
Quat = tuple[float, float, float, float]
"""x y z w."""
ARROW_HEAD = 2.0
"""Width of an arrow's head over its shaft's [-]."""


class ShapeKind(IntEnum):
    """Kinds of shapes."""

    BOX = 0
    CYLINDER = 1
    ARROW = 2
    LINE = 3
    TEXT = 4


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape."""

    kind: ShapeKind
    group: str
    row: int
    """Index of its vehicle in the order of names."""
    colour: Colour
    points: tuple[Three, ...]
    """Centre of a box, cylinder or text; tail and tip of an arrow; all of a line. [m], world."""
    size: Three = (0.0, 0.0, 0.0)
    """Extent of a box or cylinder; (width, -, -) of line and arrow; (-, -, height) of text [m]."""
    quat: Quat = (0.0, 0.0, 0.0, 1.0)
    """Orientation of a box or cylinder, x y z w."""
    text: str = ""


@dataclass(frozen=True, slots=True)
class Scene:
    """Shapes to draw at one time."""

    t: float
    """[s]"""
    names: Names
    shapes: tuple[Shape, ...]

    def group(self, name: str) -> tuple[Shape, ...]:
        """Return the shapes of one group."""
        return tuple(shape for shape in self.shapes if shape.group == name)


def arrow_quat(tail: Three, tip: Three) -> Quat:
    """Return the shortest rotation of +x to the arrow's direction; identity for an arrow of zero length.

    q = (x cross d, 1 + x . d) normalised; straight back it is half a turn about z. Backwards 1 + d_x is
    (d_y^2 + d_z^2) / (1 - d_x), which does not cancel.
    """
    dx, dy, dz = (to - start for start, to in zip(tail, tip, strict=True))
    length = math.hypot(dx, dy, dz)
    if length == 0.0:
        return (0.0, 0.0, 0.0, 1.0)
    x, y, z = dx / length, -dz / length, dy / length
    w = 1.0 + x if x > 0.0 else (y * y + z * z) / (1.0 - x)
    norm = math.hypot(y, z, w)
    return (0.0, y / norm, z / norm, w / norm) if norm > 0.0 else (0.0, 0.0, 1.0, 0.0)
