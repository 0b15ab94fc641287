"""Colours of the palette are told apart by people with red-green blindness."""

from itertools import combinations

import numpy as np
import pytest

from q2q_model import palette
from q2q_model.signals.values import Array

DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
"""Linear RGB as people without M cones see it (Machado, Oliveira, Fernandes, 2009, severity 1)."""
APART = 0.18
"""Least distance of colours that are told apart [of the side of the RGB cube]; red #ff0000 and olive #808000,
which are confused, have 0.15."""


def seen(colour: str) -> Array:
    """Return a colour as people with deuteranopia see it."""
    linear = np.array(palette.rgba(colour)[:3]) ** 2.2
    return np.clip(DEUTERANOPIA @ linear, 0.0, 1.0) ** (1.0 / 2.2)


@pytest.mark.parametrize("colours", [palette.FLIGHTS, palette.VEHICLES, (palette.MEASURED, palette.MODEL)])
def test_colours_of_one_figure_are_told_apart_with_deuteranopia(colours: tuple[str, ...]) -> None:
    for one, other in combinations(colours, 2):
        assert np.linalg.norm(seen(one) - seen(other)) > APART, (one, other)


def test_a_colour_has_red_green_blue_and_opacity() -> None:
    assert palette.rgba("#ff0080", 0.5) == pytest.approx((1.0, 0.0, 128.0 / 255.0, 0.5))
