"""Score an interaction model against the pushes that recorded flights measured.

The rule is that of q2q_model.identification.force.downwash_force. A flight from which no push can be read
(neither a log of forces nor accelerometer and thrust commands) is named, and its scores are null with n = 0.

R2 is not centred: exposed rows are pushed by about the same all the time, and on the recorded real flights a
constant alone has R2 0.60 (feed-forward off) and 0.48 (on). So compare with that constant, not with 0. With
a neighbour's log rolled by 7 to 23 s a law keeps R2 0.0 to 0.2 on the very same rows, which is less than
knowing only that somebody is above, and less than 0 over all usable rows: its gain has vanished.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, carry_out, must_exist
from q2q_model.files.model_choice import check_model
from q2q_model.vehicle.constants import VEHICLES

EXAMPLE = "  ros2 run q2q_model evaluate --model model.q2q flight1 flight2 --json scores.json"


def main(words: Sequence[str] | None = None) -> int:
    """Evaluate as the command line says; return the exit status."""
    return carry_out(parser(), _prepare, words)


def _prepare(asked: Namespace) -> Work:
    check_model(asked.model)
    must_exist("bag", *asked.bags, *([asked.topics] if asked.topics else []))
    from q2q_model.tools.score_model import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("evaluate", __doc__, EXAMPLE)
    made.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="recorded flights, at least one")
    made.add_argument("--model", required=True, help="none, a shipped name, or a .q2q file")
    made.add_argument("--json", type=Path, metavar="FILE", help="scores to write")
    made.add_argument("--topics", type=Path, metavar="MAP.yaml", help="topics of bags that are not q2q's")
    made.add_argument("--vehicle", default="", choices=tuple(VEHICLES), help="in place of what bags say")
    return made


if __name__ == "__main__":
    sys.exit(main())
