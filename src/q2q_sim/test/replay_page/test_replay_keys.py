"""Keys of a replay in a headless Chromium play and step it, whatever was used before."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from replay_browser import OpenPage, hovering, needs_chromium, opened_browser

from q2q_sim.replay_page import replay_html
from q2q_sim.replay_page.replay_run import ReplayEvent

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def wide(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenPage]:
    file: Path = tmp_path_factory.mktemp("replay") / "page.html"
    run = hovering(("cf1", "cf2"), (ReplayEvent(4.0, "cf1 5 cm low"),))
    file.write_text(replay_html([run], "Keys"), encoding="utf-8")
    for browser in opened_browser():
        yield OpenPage(browser, file.as_uri(), viewport={"width": 1400, "height": 900})


@pytest.mark.parametrize(("key", "step"), [("ArrowRight", 0.1), ("Shift+ArrowLeft", -1.0)])
def test_arrows_step_through_the_flight(wide: OpenPage, key: str, step: float):
    wide.draw_at(10.0)
    wide.page.keyboard.press(key)
    assert wide.state()["t"] == pytest.approx(10.0 + step)


def test_space_pauses_and_plays(wide: OpenPage):
    wide.draw_at(5.0)
    wide.page.keyboard.press(" ")
    assert wide.state()["isPlaying"]
    wide.page.keyboard.press(" ")
    assert not wide.state()["isPlaying"]


USED = ("input[type=range]", "button:has-text('Trails')", "button.event", ".play")
"""Controls that are clicked before keys are pressed."""


@pytest.mark.parametrize("control", USED)
def test_keys_step_and_play_after_a_click_on_a_control(wide: OpenPage, control: str):
    wide.draw_at(10.0)
    used = wide.page.locator(f"q2q-replay {control}").first
    used.click()
    pressed = used.get_attribute("aria-pressed")
    wide.draw_at(10.0)
    for key, t in (("ArrowRight", 10.1), ("Shift+ArrowRight", 11.1), ("ArrowLeft", 11.0)):
        wide.page.keyboard.press(key)
        assert wide.state()["t"] == pytest.approx(t)
    wide.page.keyboard.press(" ")
    assert wide.state()["isPlaying"]
    assert used.get_attribute("aria-pressed") == pressed


def test_keys_step_and_play_after_a_camera_is_chosen_by_mouse(wide: OpenPage):
    wide.draw_at(10.0)
    cameras = wide.page.locator("q2q-replay select[aria-label=camera]")
    cameras.click()
    cameras.select_option("Side")
    wide.page.keyboard.press("ArrowRight")
    assert (cameras.input_value(), wide.state()["t"]) == ("Side", pytest.approx(10.1))


@pytest.mark.parametrize("key", [" ", "Enter"])
def test_a_button_that_is_reached_by_tab_is_pressed_by_keys(wide: OpenPage, key: str):
    wide.draw_at(10.0)
    wide.page.locator("q2q-replay select[aria-label=camera]").focus()
    wide.page.keyboard.press("Tab")
    air = wide.page.locator("q2q-replay button", has_text="Air")
    before = air.get_attribute("aria-pressed")
    for _ in range(2):  # it keeps the focus
        wide.page.keyboard.press(key)
        assert air.get_attribute("aria-pressed") != before
        before = air.get_attribute("aria-pressed")
    assert not wide.state()["isPlaying"]
    wide.page.keyboard.press("ArrowRight")
    assert wide.state()["t"] == pytest.approx(10.1)


def test_arrows_choose_in_a_list_that_is_reached_by_tab(wide: OpenPage):
    wide.draw_at(10.0)
    cameras = wide.page.locator("q2q-replay select[aria-label=camera]")
    cameras.select_option("Room")
    wide.page.locator("q2q-replay select[aria-label=speed]").focus()
    wide.page.keyboard.press("Tab")
    wide.page.keyboard.press("ArrowDown")
    assert (cameras.input_value(), wide.state()["t"]) == ("Side", 10.0)
    wide.page.keyboard.press("ArrowUp")
