"""The replay page in a headless Chromium: it plays, seeks, shows the flight's own numbers, and stays silent.

Graphics are drawn in software, so nothing here depends on a graphics card, nor on how fast pictures follow.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser
from replay_browser import IN_REPLAY, STATE, OpenPage, hovering, needs_chromium, opened_browser

from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import TEXTBOOK_065
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.replay_page import ReplayRun, replay_html, replay_run
from q2q_sim.replay_page.script_archive import FOLDER
from q2q_sim.scenarios import library

pytestmark = needs_chromium
DURATION = 24.0
"""Of the flight [s]: cf2 is above cf1 from 18 s."""
UNDER = 21.0
"""Time at which cf1 is pushed down [s]."""


@pytest.fixture(scope="module")
def runs() -> list[ReplayRun]:
    scenario = replace(library.load("table6"), duration=DURATION)
    model = find_model(scenario.model).interaction
    return [
        replay_run(fly(scenario, FlightOptions(mode=mode, model=model)), TEXTBOOK_065, mode)
        for mode in ("ignoring", "aware")
    ]


@pytest.fixture(scope="module")
def address(runs: list[ReplayRun], tmp_path_factory: pytest.TempPathFactory) -> str:
    file: Path = tmp_path_factory.mktemp("replay") / "page.html"
    file.write_text(replay_html(runs, "Two runs"), encoding="utf-8")
    return file.as_uri()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    yield from opened_browser()


@pytest.fixture(scope="module")
def wide(browser: Browser, address: str) -> Iterator[OpenPage]:
    opened = OpenPage(browser, address, viewport={"width": 1400, "height": 900})
    yield opened
    opened.page.context.close()


def test_it_plays_by_itself_without_network_or_a_word_on_the_console(browser: Browser, address: str):
    opened = OpenPage(browser, address)
    began = opened.state()
    opened.wait(f"{STATE}.t > {began['t']} + 0.2 && {STATE}.pictures > {began['pictures']} + 3")
    assert opened.state()["isPlaying"]
    assert opened.said == []
    opened.page.context.close()


def test_heights_on_the_page_are_those_of_the_flights(wide: OpenPage, runs: list[ReplayRun]):
    wide.draw_at(UNDER)
    expected = []
    for run in runs:
        tick = int(np.searchsorted(run.t, UNDER))
        for vehicle, name in enumerate(run.names):
            z, error = run.pos[tick, vehicle, 2], run.pos[tick, vehicle, 2] - run.ref_pos[tick, vehicle, 2]
            centimetres = round(100.0 * error)
            sign = {-1: "−", 0: "", 1: "+"}[int(np.sign(centimetres))]
            expected.append(f"{name} {z:.2f} m ({sign}{abs(centimetres)} cm)")
    assert wide.texts(".readout span") == expected


def test_a_vehicle_on_the_floor_has_no_negative_height(
    browser: Browser, runs: list[ReplayRun], tmp_path: Path
):
    on_floor = replace(runs[0], pos=np.where([True, True, False], runs[0].pos, -0.001))
    file = tmp_path / "page.html"
    file.write_text(replay_html([on_floor], "On the floor"), encoding="utf-8")
    opened = OpenPage(browser, file.as_uri())
    assert [one.split(" m")[0] for one in opened.texts(".readout span")] == ["cf1 0.00", "cf2 0.00"]
    opened.page.context.close()


def test_a_part_of_a_flight_has_the_times_of_the_flight(
    browser: Browser, runs: list[ReplayRun], tmp_path: Path
):
    file = tmp_path / "page.html"
    file.write_text(replay_html([replace(runs[0], since=7.0)], "A part"), encoding="utf-8")
    opened = OpenPage(browser, file.as_uri())
    opened.draw_at(1.0)
    assert opened.texts(".time") == ["8.0 / 31.0 s"]
    assert opened.texts(".event") == ["28.8 s: cf1 34 cm low"]
    opened.page.context.close()


def test_captions_tell_what_happened(wide: OpenPage):
    ignoring, aware = wide.texts("figcaption")
    assert ignoring.startswith("ignoring cf1 pushed 34 cm down at 21.8 s")
    assert aware.startswith("aware ")


def test_every_time_below_the_curves_is_whole(browser: Browser, runs: list[ReplayRun], tmp_path: Path):
    count = int((runs[0].t[-1] - runs[0].t[0]) * 50.0 + 1e-6)  # steps of the page's own rate, 50 Hz
    file = tmp_path / "page.html"
    file.write_text(replay_html([replace(runs[0], since=25.0 - count / 50.0)], "To 25 s"), encoding="utf-8")
    noted = """window.labels = [];
    const { fillText } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
      labels.push([text, x + this.measureText(text).width / 2 - this.canvas.width / devicePixelRatio]);
      fillText.call(this, text, x, y);
    };"""
    opened = OpenPage(browser, file.as_uri(), init=noted)
    beyond = dict(opened.page.evaluate("labels"))
    assert "25 s" in beyond
    assert max(beyond[text] for text in beyond if text.endswith(" s")) <= 0.0
    opened.page.context.close()


def test_the_time_bar_and_the_curves_seek(wide: OpenPage):
    wide.draw_at(1.0)
    wide.page.locator("q2q-replay input[type=range]").fill("12.5")
    assert wide.state()["t"] == pytest.approx(12.5)
    wide.page.locator("q2q-replay .curves").first.click(position={"x": 40, "y": 60})  # the curves' left edge
    assert wide.state()["t"] == 0.0


def test_a_vehicle_that_sinks_sinks_in_the_room(wide: OpenPage):
    rows = []
    for t in (10.0, UNDER):
        wide.draw_at(t)
        red, green, blue = np.moveaxis(wide.picture(), -1, 0)
        of_first = (blue > 2.5 * red) & (blue > green) & (blue > 0.3)  # its colour, #0072b2
        rows.append(np.nonzero(of_first)[0].mean())
    assert rows[1] > rows[0] + 5.0  # pixels, from the top


def test_a_layer_is_hidden_by_its_button(wide: OpenPage):
    wide.draw_at(UNDER)
    air = wide.page.locator("q2q-replay button", has_text="Air")
    coloured = []
    for _ in range(2):
        coloured.append((np.ptp(wide.picture(), axis=-1) > 0.2).sum())  # pixels that are not grey
        before = wide.state()["pictures"]
        air.click()
        wide.wait(f"{STATE}.pictures > {before}")
    assert coloured[1] < 0.8 * coloured[0]


def test_a_change_of_colour_scheme_draws_the_same_moment_in_other_colours(browser: Browser, address: str):
    opened = OpenPage(browser, address, viewport={"width": 1400, "height": 900})
    opened.page.locator("q2q-replay button", has_text="Air").click()
    opened.page.locator("q2q-replay select[aria-label=camera]").select_option("Side")
    opened.draw_at(UNDER)
    light = opened.picture()
    for scheme in ("dark", "light"):
        before = opened.state()["pictures"]
        opened.page.emulate_media(color_scheme=scheme)
        opened.wait(f"{STATE}.pictures > {before}")
        after = opened.state()
        assert (after["t"], after["isPlaying"]) == (UNDER, False)
        shown = opened.picture()
        assert (np.median(shown) < 0.2) == (scheme == "dark")
    assert np.mean(shown != light) < 1e-4  # what is equally deep is drawn in another order
    assert opened.texts(".label") == ["cf1", "cf2", "cf1", "cf2"]
    assert opened.said == []
    opened.page.context.close()


def test_a_followed_vehicle_is_followed_after_the_window_changes(browser: Browser, address: str):
    opened = OpenPage(browser, address, viewport={"width": 1400, "height": 900})
    opened.page.locator("q2q-replay select[aria-label=camera]").select_option(label="follow cf2")
    for width in (1400, 1000):
        before = opened.state()["pictures"]
        opened.page.set_viewport_size({"width": width, "height": 900 - width // 100})
        opened.wait(f"{STATE}.pictures > {before}")
        opened.draw_at(UNDER)
        label = opened.page.locator("q2q-replay .label", has_text="cf2").first.bounding_box()
        room = opened.page.locator("q2q-replay canvas.room").first.bounding_box()
        assert label is not None
        assert room is not None
        middle = room["x"] + room["width"] / 2
        assert label["x"] + label["width"] / 2 == pytest.approx(middle, abs=1.0)  # pixel
    opened.page.context.close()


@pytest.mark.parametrize(("wake_speed", "above"), [(2.0, 1.0), (np.inf, 1.0), (np.inf, 2.0)])
def test_the_air_nearest_to_a_pushed_vehicle_is_warm_also_where_it_is_drawn_beside_it(
    browser: Browser, tmp_path: Path, wake_speed: float, above: float
):
    """cf1 is below and 0.3 m beside cf2, whose air it is in, and is pushed by too little for an arrow.

    In both flights it is pushed at the end: air is not drawn where there is no push at all.
    """
    t = 0.1 * np.arange(20)
    pos = np.tile([(0.0, 0.0, 0.5), (0.3, 0.0, 0.5 + above)], (len(t), 1, 1))
    unknown = np.full_like(pos, np.nan)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 2, 1))
    made = ReplayRun(
        "made", ("cf1", "cf2"), t, pos, level, unknown, unknown, np.zeros((len(t), 2), dtype=np.bool_),
        np.zeros_like(pos), np.ones((len(t), 2)), 0.046, wake_speed=wake_speed,
    )  # fmt: skip
    blue_pixels = []
    for push in (0.0, -0.09):
        file = tmp_path / "page.html"
        pushed = np.tile([(0.0, 0.0, push), (0.0, 0.0, 0.0)], (len(t), 1, 1))
        pushed[-1, 0, 2] = -0.09
        file.write_text(replay_html([replace(made, downwash=pushed)], "Air"), encoding="utf-8")
        opened = OpenPage(browser, file.as_uri(), color_scheme="light")
        opened.draw_at(1.0)
        red, _, blue = np.moveaxis(opened.picture(), -1, 0)
        blue_pixels.append((blue > red + 0.06).sum())
        opened.page.context.close()
    assert blue_pixels[1] < 0.5 * blue_pixels[0]  # the other half is the air of cf1, which pushes nobody


def test_air_that_pushes_nobody_is_neither_drawn_nor_explained(browser: Browser, tmp_path: Path):
    """As in a flight of one vehicle; a flight that does not record the downwash shows its air."""
    made = hovering(("cf1",))
    for downwash, shown in ((np.zeros_like(made.pos), False), (made.downwash, True)):
        file = tmp_path / "page.html"
        file.write_text(replay_html([replace(made, downwash=downwash)], "Alone"), encoding="utf-8")
        opened = OpenPage(browser, file.as_uri())
        opened.draw_at(1.0)
        assert ("Air" in opened.texts("button")) == shown
        assert "Air turns" not in opened.texts(".notes")[0]
        assert opened.said == []
        opened.page.context.close()


def test_between_two_ticks_a_tumbling_vehicle_turns_the_short_way(wide: OpenPage):
    half = np.pi * np.array([0.49, 0.51])  # at two ticks, half the angle about x: w passes zero
    quat = np.column_stack([np.sin(half), 0.0 * half, 0.0 * half]) * np.sign(np.cos(half))[:, None]
    found = of_recorded_run(wide, "quat", quat, "[0, 0.25, 0.5, 1].map(t => run.orientation(0, t))")
    turned = np.pi * np.array([0.49, 0.495, 0.5, 0.51])
    expected = np.column_stack([np.sin(turned), 0.0 * turned, 0.0 * turned, np.cos(turned)])
    along = np.abs(np.sum(np.asarray(found) * expected, axis=1))  # q and -q are one orientation
    assert along == pytest.approx(np.ones(4), abs=1e-6)  # single precision


def test_the_strongest_push_is_that_of_one_tick(wide: OpenPage):
    push = np.array([[3.0, 0.0, 0.0], [0.0, 0.0, -4.0]])
    assert of_recorded_run(wide, "downwash", push, "run.strongestPush()") == pytest.approx(4.0)


def of_recorded_run(page: OpenPage, channel: str, values: Array, expression: str) -> object:
    """Return what JavaScript finds in a run of one vehicle, a tick a second, with one channel (T, 3)."""
    module = (FOLDER / "player" / "recorded_run.js").read_text(encoding="utf-8")
    alone = module.replace('import { tinted } from "./colours.js";', "")
    return page.page.evaluate(
        f"""async ([text, channel, columns]) => {{
          const {{ RecordedRun }} = await import("data:text/javascript," + encodeURIComponent(text));
          const facts = {{ names: ["cf1"], count: columns[0].length, rate: 1 }};
          const values = new Float32Array(columns.flat());
          const run = new RecordedRun(facts, {{ [channel]: {{ width: 3, values }} }});
          return {expression};
        }}""",
        [alone, channel, values.T.tolist()],
    )


def test_a_phone_has_large_buttons_and_nothing_beside_the_screen(browser: Browser, address: str):
    phone = OpenPage(
        browser, address, viewport={"width": 400, "height": 800}, is_mobile=True, has_touch=True,
        reduced_motion="reduce",
    )  # fmt: skip
    assert not phone.state()["isPlaying"], "who wants little motion starts the replay himself"
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 400
    touched = f"[...{IN_REPLAY}.querySelectorAll('button, select, input')]"
    heights = phone.page.evaluate(f"{touched}.map(e => e.getBoundingClientRect().height)")
    assert min(heights) >= 40
    phone.page.locator("q2q-replay .play").tap()
    phone.wait(f"{STATE}.t > 0")
    assert phone.said == []
    phone.page.context.close()


def test_without_webgl_one_sentence_says_so_and_the_curves_play(browser: Browser, address: str):
    without = """for (const { prototype } of [HTMLCanvasElement, OffscreenCanvas]) {
      const known = prototype.getContext;
      prototype.getContext = function (kind, ...rest) {
        return kind.startsWith('webgl') ? null : known.call(this, kind, ...rest);
      };
    }"""
    flat = OpenPage(browser, address, init=without)
    assert all("WebGL is off" in text for text in flat.texts(".stage"))
    flat.wait(f"{STATE}.t > 0.1")
    flat.draw_at(UNDER)
    assert flat.texts(".readout span")[0].startswith("cf1 1.2")
    assert flat.said == []
    flat.page.context.close()
