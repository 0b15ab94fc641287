"""A replay of many vehicles in a headless Chromium says which is which, and stays as long as a screen."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from replay_browser import OpenPage, hovering, needs_chromium, opened_browser

from q2q_sim.replay_page import replay_html
from q2q_sim.replay_page.replay_run import ReplayEvent

pytestmark = needs_chromium
NAMES = tuple(f"cf{each}" for each in range(1, 13))
COLLISIONS = tuple(ReplayEvent(0.1 * each, "cf6 and cf9 collided, 0.03 m apart") for each in range(30))


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
