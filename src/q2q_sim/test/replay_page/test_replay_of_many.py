"""A replay of many vehicles in a headless Chromium says which is which, and stays as long as a screen."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser
from replay_browser import IN_REPLAY, OpenPage, hovering, needs_chromium, opened_browser

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


def test_of_many_vehicles_those_that_marked_moments_name_are_labelled_and_have_a_readout(
    many: OpenPage,
) -> None:
    many.draw_at(1.0)
    assert many.texts(".label:not([hidden])") == ["cf6", "cf9"]
    assert many.texts(".readout span") == [
        "12 vehicles: point at one",
        "cf6 1.25 m (0 cm)",
        "cf9 1.40 m (0 cm)",
    ]


def test_a_vehicle_that_is_pointed_at_in_the_room_or_in_the_curves_is_named(many: OpenPage) -> None:
    many.draw_at(1.0)
    six = many.page.locator("q2q-replay .label", has_text="cf6").bounding_box()
    nine = many.page.locator("q2q-replay .label", has_text="cf9").bounding_box()
    assert six is not None
    assert nine is not None
    share = 1.0 / 3.0  # of the way from cf6 to cf9 is cf7, but for the perspective
    many.page.mouse.move(
        six["x"] + six["width"] / 2 + share * (nine["x"] - six["x"]),
        six["y"] + six["height"] + share * (nine["y"] - six["y"]),
    )
    many.wait(f"{IN_REPLAY}.querySelector('.pointed').textContent.startsWith('cf')")
    assert many.texts(".pointed") == ["cf7 1.30 m (0 cm)"]
    assert many.texts(".label:not([hidden])") == ["cf6", "cf7", "cf9"]
    curves = many.page.locator("q2q-replay .curves").bounding_box()
    assert curves is not None
    many.page.mouse.move(curves["x"] + 200, curves["y"] + curves["height"] - 4)  # below all curves
    many.wait(f"{IN_REPLAY}.querySelector('.pointed').textContent.startsWith('12')")
    above, below = 8.0, 22.0  # of the curves [px]
    share = (1.60 - 1.45) / (1.60 - 0.95)  # cf10 from the upper edge: 5 cm beyond the vehicles at both
    down = above + share * (curves["height"] - above - below)
    many.page.mouse.move(curves["x"] + 200, curves["y"] + down)
    many.wait(f"{IN_REPLAY}.querySelector('.pointed').textContent.startsWith('cf')")
    assert many.texts(".pointed") == ["cf10 1.45 m (0 cm)"]


def test_labels_of_vehicles_in_one_place_do_not_cover_each_other(browser: Browser, tmp_path: Path) -> None:
    run = hovering(("cf1", "cf2", "cf3"))
    together = replace(run, pos=np.tile(run.pos[:, :1], (1, 3, 1)))
    file = tmp_path / "page.html"
    file.write_text(replay_html([together], "One place"), encoding="utf-8")
    opened = OpenPage(browser, file.as_uri())
    opened.draw_at(1.0)
    boxes = [label.bounding_box() for label in opened.page.locator("q2q-replay .label").all()]
    tops = [box["y"] for box in boxes if box is not None]
    assert len(tops) == 3
    assert np.diff(tops) == pytest.approx(-boxes[0]["height"], abs=0.5)  # in whole pixels
    opened.page.context.close()


def test_long_names_fit_a_phone_and_labels_show_where_they_differ(browser: Browser, tmp_path: Path) -> None:
    names = tuple(f"crazyflie_number_{each}_of_the_great_western_laboratory_swarm" for each in (9, 10, 11))
    said = "; ".join(f"{name} hit the floor" for name in names)
    run = replace(hovering(names, (ReplayEvent(1.0, said),)), name=names[0], verdict=said)
    file = tmp_path / "page.html"
    file.write_text(replay_html([run], names[0]), encoding="utf-8")
    phone = OpenPage(browser, file.as_uri(), viewport={"width": 390, "height": 844}, is_mobile=True)
    phone.draw_at(1.0)
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 390
    parts = f"[...{IN_REPLAY}.querySelectorAll('button, select, figcaption, .readout span')]"
    assert max(phone.page.evaluate(f"{parts}.map(e => e.getBoundingClientRect().right)")) <= 390
    assert phone.texts(".label") == ["…9…", "…10…", "…11…"]
    assert [text.split()[0] for text in phone.texts(".readout span")] == list(names)
    phone.page.context.close()
