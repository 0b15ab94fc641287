"""Replay of recorded flights in a browser: room, vehicles, downwash and height curves.

    Flight -> replay_run -> ReplayRun -> replay_html (a page) or replay_element (a part of another page)

The page is one file, needs no server and no network, and plays up to three runs side by side in step. Its
scripts are ES modules in `player/`, drawn by three.js (`three/`); `script_archive` embeds both compressed.
"""

from q2q_sim.replay_page.measured_downwash import with_measured_downwash
from q2q_sim.replay_page.replay_html import MOST_RUNS, replay_element, replay_html
from q2q_sim.replay_page.replay_run import ReplayEvent, ReplayRun, in_air, replay_run

__all__ = [
    "MOST_RUNS",
    "ReplayEvent",
    "ReplayRun",
    "in_air",
    "replay_element",
    "replay_html",
    "replay_run",
    "with_measured_downwash",
]
