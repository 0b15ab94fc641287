"""Call the flight procedure: start, take_off, fly, hold, land, emergency.

Prints the answer. The exit status is 0 if the call was granted, 1 if it was refused or not answered. The
calls are std_srvs/Trigger services of the nodes radio and crazyswarm. With their option --dry-run they
execute none but emergency, which always stops the motors.
"""

import re
import sys
from argparse import ArgumentTypeError, Namespace
from collections.abc import Sequence

from q2q_control.flight_procedure.steps import Call
from q2q_model.commands.command_line import CommandLine, Work, run_command

EXAMPLE = """  ros2 run q2q_control call take_off
  ros2 run q2q_control call emergency --on-enter
  ros2 run q2q_control call emergency --node crazyswarm"""

_NODE = re.compile(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def main(argv: Sequence[str] | None = None) -> int:
    """Make one call; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; the call continues")


def _prepare(_: Namespace) -> Work:
    from q2q_control.tools.call_procedure import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("call", __doc__, EXAMPLE)
    made.add_argument("call", choices=[one.value for one in Call], help="call to make")
    made.add_argument(
        "--node", default="radio", type=_node, help="node that flies the vehicles: radio or crazyswarm"
    )
    made.add_argument(
        "--on-enter",
        action="store_true",
        help="find the service now, and call it when Enter is pressed; for the emergency stop",
    )
    return made


def _node(given: str) -> str:
    """Return the name of a node, with its namespace if it has one: a type of arguments."""
    name = given.strip("/")
    if not _NODE.fullmatch(name):
        raise ArgumentTypeError(f"{given!r} is not a node name: give one like radio or room/radio")
    return name


if __name__ == "__main__":
    sys.exit(main())
