"""Call the flight procedure: start, take_off, fly, hold, land, emergency.

Prints the answer; ends with 0 where the call was granted, with 1 where it was refused or nobody answers. The
calls are std_srvs/Trigger services of the nodes radio and crazyswarm.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_control.flight_procedure.steps import Call
from q2q_model.commands.command_line import CommandLine, Work, carry_out

EXAMPLE = """  ros2 run q2q_control call take_off
  ros2 run q2q_control call emergency --node crazyswarm"""


def main(words: Sequence[str] | None = None) -> int:
    """Make one call; return the exit status."""
    return carry_out(parser(), _prepare, words, interrupted="interrupted; what was asked for goes on")


def _prepare(_: Namespace) -> Work:
    from q2q_control.tools.call_procedure import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("call", __doc__, EXAMPLE)
    made.add_argument("call", choices=[one.value for one in Call], help="what to ask for")
    made.add_argument("--node", default="radio", help="who flies the vehicles: radio or crazyswarm")
    return made


if __name__ == "__main__":
    sys.exit(main())
