"""Doubt whether z of recorded positions is the height, which positions without attitudes do not show.

Vehicles fly above a floor, and motion capture is calibrated on it: the height is the axis that is never far
below zero. In 34 public flights and 6 bags z is below FLOOR in less than 1 % of the positions, the outliers;
turned to a frame whose y is up, 36 of the 40 raise this doubt; those that move to one side only do not. With
z down (north, east, down) all of them raise it; where y, too, is never below the floor, y may be up instead.
In a room whose origin is above its floor the doubt may be wrong, so no flight is refused for it.
"""

import numpy as np

from q2q_model.signals.values import Array

FLOOR = -0.1
"""Height that no vehicle is below [m]: the origin is nearer to the floor than that."""
OUTLIERS = 0.02
"""Share of the positions that may be outliers [-]: twice that of the noisiest bag."""


def up_axis_reason(pos: Array) -> str:
    """Return why z seems not to be up in positions (..., 3), NaN where unknown; empty if it may be."""
    known = pos[np.isfinite(pos).all(axis=-1)]
    if not len(known):
        return ""
    y, z = (float((known[:, axis] < FLOOR).mean()) for axis in (1, 2))
    above = float((known[:, 2] > -FLOOR).mean())
    if z <= OUTLIERS or min(y, above) > OUTLIERS:
        return ""
    share, doubt = f"and y in {y:.0%}", "y may be up"
    if above <= OUTLIERS:
        share, doubt = (
            f"and above {-FLOOR:g} m in {above:.0%}",
            "z may be down" if y > OUTLIERS else "z may be down, or y up",
        )
    return (
        f"z is below {FLOOR:g} m in {z:.0%} of the positions {share}: {doubt}, but z must be up: a "
        "column map turns the axes of a table (bag_import --columns)"
    )
