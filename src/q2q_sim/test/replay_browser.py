"""Headless Chromium that opens replay pages, and a run that is made for one, for tests.

Graphics are drawn in software, so nothing depends on a graphics card, nor on how fast pictures follow.
"""

import shutil
from collections.abc import Iterator
from io import BytesIO

import numpy as np
import pytest
from matplotlib.image import imread
from playwright.sync_api import Browser, sync_playwright

from q2q_model.signals.values import Array
from q2q_sim.replay_page import ReplayRun
from q2q_sim.replay_page.replay_run import ReplayEvent

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium")
FLAGS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
         "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync")  # fmt: skip
PATIENCE_MS = 600_000
"""A busy machine draws the first picture within this [ms]."""
T: Array = 0.02 * np.arange(1001)
"""Ticks of a run that is made [s]."""
STATE = "document.querySelector('q2q-replay').state"
IN_REPLAY = "document.querySelector('q2q-replay').shadowRoot"


def hovering(names: tuple[str, ...], events: tuple[ReplayEvent, ...] = ()) -> ReplayRun:
    """Return vehicles that hover 0.5 m apart in a row along x, each 5 cm above the last."""
    unknown = np.full((len(T), len(names), 3), np.nan)
    pos = np.zeros_like(unknown)
    pos[..., 0] = 0.5 * np.arange(len(names))
    pos[..., 2] = 1.0 + 0.05 * np.arange(len(names))
    return ReplayRun(
        name="made",
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


def opened_browser() -> Iterator[Browser]:
    """Yield a browser for the tests of a module."""
    with sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield opened
        opened.close()


class OpenPage:
    """Page of the replay once it has drawn, and what its console said."""

    def __init__(self, browser: Browser, address: str, init: str = "", **context: object) -> None:
        self.said: list[str] = []
        self.page = browser.new_context(offline=True, **context).new_page()
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.add_init_script(init)
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.goto(address)
        self.wait(f"{STATE}?.pictures > 0")

    def wait(self, condition: str) -> None:
        """Wait until a condition in JavaScript holds."""
        self.page.wait_for_function(f"document.querySelector('q2q-replay') && {condition}")

    def state(self) -> dict[str, float]:
        """Return the element's state."""
        return self.page.evaluate(STATE)

    def draw_at(self, t: float) -> None:
        """Pause at time t [s], and wait until that is drawn."""
        seek = f"it => {{ it.pause(); it.seek({t}); return it.state.pictures; }}"
        before = self.page.evaluate(f"({seek})(document.querySelector('q2q-replay'))")
        self.wait(f"{STATE}.pictures > {before}")

    def picture(self) -> Array:
        """Return the first room without the vehicles' names: red, green, blue, (rows, columns, 3)."""
        room = self.page.locator("q2q-replay canvas.room").first
        png = room.screenshot(style=".label { display: none }")
        return np.asarray(imread(BytesIO(png))[..., :3], dtype=np.float64)

    def texts(self, selector: str) -> list[str]:
        """Return the texts of elements inside the replay."""
        return self.page.evaluate(f"[...{IN_REPLAY}.querySelectorAll('{selector}')].map(e => e.textContent)")
