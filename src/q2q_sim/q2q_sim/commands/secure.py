"""Set up DDS security: keys, and an access policy that allows each node only the topics and services it uses.

Writes the access policy of all nodes and, with `ros2 security` (SROS2, of a sourced ROS 2), a keystore with
an enclave for each node. The permissions are valid in the current ROS_DOMAIN_ID. The exit status is 1 if the
middleware of this machine was built without security.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, run_command

KEYSTORE = Path("out/keystore")
EXAMPLE = """  scripts/secure --vehicles cf1 cf2 --operators desk
  scripts/secure --policy policy.xml"""


def main(argv: Sequence[str] | None = None) -> int:
    """Write policy and keystore; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(_: Namespace) -> Work:
    from q2q_sim.tools.secure_nodes import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("secure", __doc__, EXAMPLE)
    made.add_argument(
        "--keystore", type=Path, default=KEYSTORE, help="folder of the keystore; an existing one is kept"
    )
    made.add_argument(
        "--vehicles", nargs="+", default=[], metavar="NAME", help="names of the vehicles; default: any name"
    )
    made.add_argument(
        "--operators",
        nargs="+",
        default=["operator"],
        metavar="NAME",
        help="enclaves that may call all/emergency and the flight procedure",
    )
    made.add_argument(
        "--policy", type=Path, help="write only the access policy, to this file, and no keystore"
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
