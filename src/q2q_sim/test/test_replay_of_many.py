"""A replay of many vehicles in a headless Chromium says which is which, and stays as long as a screen."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser
from replay_browser import OpenPage, needs_chromium, opened_browser

from q2q_sim.replay_page import ReplayRun, replay_html
from q2q_sim.replay_page.replay_run import ReplayEvent

pytestmark = needs_chromium
T = 0.02 * np.arange(500)
NAMES = tuple(f"cf{each}" for each in range(1, 13))
COLLISIONS = tuple(ReplayEvent(0.1 * each, "cf6 and cf9 collided, 0.03 m apart") for each in range(30))


def hovering(names: tuple[str, ...], events: tuple[ReplayEvent, ...] = ()) -> ReplayRun:
    """Return vehicles that hover 0.5 m apart in a row along x, each 5 cm above the last."""
    unknown = np.full((len(T), len(names), 3), np.nan)
    pos = np.zeros_like(unknown)
    pos[..., 0] = 0.5 * np.arange(len(names))
    pos[..., 2] = 1.0 + 0.05 * np.arange(len(names))
    return ReplayRun(
        name="many",
        names=names,
        t=T,
        pos=pos,
        quat=np.full((*pos.shape[:2], 4), np.nan),
        ref_pos=pos,
        mocap_pos=unknown,
        rejected=np.zeros(pos.shape[:2], dtype=np.bool_),
        downwash=unknown,
        thrust=np.ones(pos.shape[:2]),
        arm=0.046,
        events=events,
    )


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    yield from opened_browser()


@pytest.fixture
def many(browser: Browser, tmp_path: Path) -> Iterator[OpenPage]:
    file = tmp_path / "page.html"
    file.write_text(replay_html([hovering(NAMES, COLLISIONS)], "Many"), encoding="utf-8")
    opened = OpenPage(browser, file.as_uri(), viewport={"width": 1400, "height": 900})
    yield opened
    opened.page.context.close()


def test_of_many_marked_moments_the_first_have_buttons_and_one_adds_the_others(many: OpenPage) -> None:
    shown = many.texts(".event")
    assert (len(shown), shown[-1]) == (11, "20 more")
    height = "document.documentElement.scrollHeight"
    before = many.page.evaluate(height)
    many.page.locator("q2q-replay .event", has_text="20 more").click()
    assert many.texts(".event") == [f"{one.t:.1f} s: {one.words}" for one in COLLISIONS]
    assert many.page.evaluate(height) < before + 400
