"""HTML of a replay: a whole page, or an element for another page."""

import json
from collections.abc import Sequence
from html import escape

from q2q_sim.replay_page.packed_run import RATE_HZ, packed_run
from q2q_sim.replay_page.replay_run import ReplayRun
from q2q_sim.replay_page.script_archive import loader, script_archive

MOST_RUNS = 3
"""Runs side by side."""
MOST_BYTES = 1_900_000
"""Size of an element, so that a page with some text stays below 2 MB."""
RATES_HZ = (RATE_HZ, 25.0, 10.0, 5.0, 2.0, 1.0)
"""Rates of samples that are tried in turn until the runs fit."""
PAGE_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; padding: 1rem; max-width: 1600px; }
body { background: #ffffff; color: #1c2127; }
@media (prefers-color-scheme: dark) { body { background: #14171c; color: #e4e7eb; } }
h1 { font-size: 1.35rem; margin: 0 0 .75rem; font-weight: 650; overflow-wrap: anywhere; }
"""


def replay_html(runs: Sequence[ReplayRun], title: str) -> str:
    """Return a page that replays one to three runs; raise ValueError for more, or none."""
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{PAGE_STYLE}</style></head>\n"
        f"<body><h1>{escape(title)}</h1>\n{replay_element(runs)}\n</body></html>\n"
    )


def replay_element(runs: Sequence[ReplayRun]) -> str:
    """Return the HTML of an element that replays one to three runs, for the body of any page.

    It brings its own scripts and style, fills the width that it is given and leaves the page's style alone.
    A page may hold several.

    Raises:
        ValueError: no run, too many, or runs too long for a page.
    """
    if not 1 <= len(runs) <= MOST_RUNS:
        raise ValueError(f"{len(runs)} runs; must be 1 to {MOST_RUNS} side by side")
    for rate in RATES_HZ:
        element = _element([packed_run(run, rate) for run in runs])
        if len(element) <= MOST_BYTES:
            return element
    flown = sum(len(run.names) * float(run.t[-1] - run.t[0]) for run in runs)
    raise ValueError(f"{flown:.0f} s of flights, over all vehicles, exceed a page of 2 MB: replay a part")


def _element(runs: Sequence[object]) -> str:
    data = "\n".join(f'<script type="application/json">{_embedded(run)}</script>' for run in runs)
    return (
        f"<q2q-replay>\n{data}\n<noscript>The replay needs JavaScript.</noscript>\n</q2q-replay>\n"
        f'<script type="text/plain" class="q2q-replay-archive">{script_archive()}</script>\n'
        f'<script type="module">\n{loader()}</script>'
    )


def _embedded(run: object) -> str:
    """Return JSON that no HTML parser takes for the end of its script."""
    return json.dumps(run, separators=(",", ":")).replace("<", "\\u003c")
