"""Write a page for each node into docs/nodes: topics, types, qualities of service, services, parameters.

The text of a page is the docstring of the node's module; the tables are what the node declares. `--images`
draws the figures of the documentation.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_types import output_folder
from q2q_model.commands.command_line import CommandLine, Work, run_command

OUT = Path("docs/nodes")


def main(argv: Sequence[str] | None = None) -> int:
    """Write or check the pages; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(_: Namespace) -> Work:
    from q2q_sim.tools.docs.write_node_pages import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    examples = "  scripts/node_pages\n  scripts/node_pages --check\n  scripts/node_pages --images"
    made = CommandLine("node_pages", __doc__, examples)
    made.add_argument("--out", type=output_folder, default=OUT, help="folder of the pages")
    made.add_argument("--check", action="store_true", help="write nothing; fail if a page is out of date")
    made.add_argument("--images", action="store_true", help="also draw docs/images")
    return made


if __name__ == "__main__":
    sys.exit(main())
