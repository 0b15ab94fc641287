"""The colours of the first vehicles of a replay are told apart, whether or not colours are seen well."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pytest
from playwright.sync_api import Browser
from replay_browser import needs_chromium, opened_browser

from q2q_model import palette
from q2q_model.signals.values import Array
from q2q_sim.replay_page.script_archive import FOLDER

pytestmark = needs_chromium

LABELLED = 8
"""Vehicles whose names a replay shows all the time (recorded_run.js)."""
APART = 20.0
"""Least distance in CIELAB of colours of two vehicles; 2.3 is just noticeable side by side (Sharma, 2003)."""
XYZ_OF_RGB = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
"""From linear sRGB, white D65 (IEC 61966-2-1)."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Yield a browser."""
    yield from opened_browser()


@pytest.fixture
def colours(browser: Browser) -> list[str]:
    """Return the colours of the first vehicles of a replay."""
    module = (FOLDER / "player" / "colours.js").read_text(encoding="utf-8")
    found = browser.new_page().evaluate(
        """async ([text, palette, count]) => {
          const { tinted } = await import("data:text/javascript," + encodeURIComponent(text));
          return Array.from({ length: count }, (_, vehicle) => tinted(palette, vehicle));
        }""",
        [module, palette.VEHICLES, LABELLED],
    )
    return [str(one) for one in found]


def lab(colour: str) -> Array:
    """Return L*, a*, b* of a colour (CIE 1976)."""
    shares = np.array(palette.rgba(colour)[:3])
    linear = np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)
    x, y, z = np.vectorize(_lightness)(XYZ_OF_RGB @ linear / XYZ_OF_RGB.sum(axis=1))
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def _lightness(share: float) -> float:
    return float(np.cbrt(share)) if share > 216.0 / 24389.0 else (24389.0 / 27.0 * share + 16.0) / 116.0


def test_white_is_100_from_black_and_red_is_where_it_is_published() -> None:
    assert np.linalg.norm(lab("#ffffff") - lab("#000000")) == pytest.approx(100.0, abs=1e-9)
    assert lab("#ff0000") == pytest.approx([53.24, 80.09, 67.20], abs=0.01)


def test_no_two_of_the_first_vehicles_have_nearly_the_same_colour(colours: list[str]) -> None:
    assert tuple(colours[: len(palette.VEHICLES)]) == palette.VEHICLES
    for one, other in combinations(colours, 2):
        assert np.linalg.norm(lab(one) - lab(other)) > APART, (one, other)
