"""Errors of a user's controller, read from the logs of its flight."""

from pathlib import Path

from q2q_sim.node_flights.controller_errors import controller_errors

LOG = """[INFO] [1.0] [own_controller]: running
[ERROR] [2.0] [own_controller]: controller mine:Pd: update raised KeyError: 'mode' (mine.py, line 3)
[ERROR] [3.0] [mocap_filter]: another node
[ERROR] [4.0] [own_controller]: controller mine:Pd: update raised KeyError: 'mode' (mine.py, line 3)
"""


def test_each_error_is_shown_once(tmp_path: Path) -> None:
    (tmp_path / "stack.log").write_text(LOG)
    assert controller_errors(tmp_path) == [
        "controller mine:Pd: update raised KeyError: 'mode' (mine.py, line 3)"
    ]
