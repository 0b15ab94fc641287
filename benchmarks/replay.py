"""Replay pages in a headless Chromium that draws by the processor: size, first picture, pictures per second.

The pages are those of docs/replay.md: the most vehicles for which 30 pictures per second and a first one
within 1 s are wanted, and two vehicles in three runs side by side. A browser with a graphics card is faster.
"""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from playwright.sync_api import Browser, sync_playwright

from q2q_model.model_files.find_model import find_model
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode
from q2q_sim.replay_page import ReplayRun, replay_html, replay_run
from q2q_sim.scenarios import library
from row import Row

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WINDOW = {"width": 1400, "height": 900}
"""[px]"""
PAGES: tuple[tuple[str, tuple[Mode, ...]], ...] = (
    ("swarm20", ("aware",)),
    ("table6", ("ignoring", "aware", "aware_unlimited")),
)
"""Scenario and modes of each page."""
LARGEST_MB, LATEST_S, FEWEST_HZ = 2.0, 1.0, 30.0
"""Size, first picture and pictures per second that are wanted."""
SETTLING_MS, COUNTED_S = 3000, 5.0
"""Time in which the page chooses how many pixels it draws, and time in which pictures are counted."""
PICTURES = "document.querySelector('q2q-replay')?.state?.pictures ?? 0"


def run() -> list[Row]:
    """Return the rows of this area; none where there is no Chromium."""
    if CHROMIUM is None:
        print("bench: replay: no Chromium: apt-get install chromium", file=sys.stderr)
        return []
    with TemporaryDirectory() as folder, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        rows = [row for name, modes in PAGES for row in page_rows(browser, Path(folder), name, modes)]
        browser.close()
    return rows


def page_rows(browser: Browser, folder: Path, name: str, modes: tuple[Mode, ...]) -> list[Row]:
    """Return the rows of the page of a scenario's flights."""
    file = folder / f"{name}.html"
    file.write_text(replay_html([flown(name, mode) for mode in modes], name), encoding="utf-8")
    size = 1e-6 * file.stat().st_size
    first, rate = played(browser, file)
    label = f"{name}, {len(modes)} side by side" if len(modes) > 1 else name
    return [
        Row(f"{label}: size of the page", size, "MB", f"at most {LARGEST_MB:g} MB", LARGEST_MB / size),
        Row(f"{label}: first picture", first, "s", f"within {LATEST_S:g} s", LATEST_S / first),
        Row(f"{label}: pictures per second", rate, "1/s", f"at least {FEWEST_HZ:g} / s", rate / FEWEST_HZ),
    ]


def flown(name: str, mode: Mode) -> ReplayRun:
    """Return the flight of a scenario in a mode."""
    scenario = library.load(name)
    flight = fly(scenario, FlightOptions(mode=mode, model=find_model(scenario.model).interaction))
    return replay_run(flight, scenario.vehicle, mode)


def played(browser: Browser, file: Path) -> tuple[float, float]:
    """Return the time until the first picture [s], and the pictures per second from then on [1/s]."""
    page = browser.new_context(offline=True, viewport=WINDOW).new_page()
    begin = perf_counter()
    page.goto(file.as_uri(), wait_until="commit")
    page.wait_for_function(f"{PICTURES} > 0")
    first = perf_counter() - begin
    page.wait_for_timeout(SETTLING_MS)
    since, before = perf_counter(), page.evaluate(PICTURES)
    page.wait_for_timeout(1e3 * COUNTED_S)
    rate = (page.evaluate(PICTURES) - before) / (perf_counter() - since)
    page.context.close()
    return first, rate
