"""Start of a node: import of its module, which takes most of the start-up time, and call of its `main`."""

import sys
from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from q2q_model.commands.clean_exit import exiting_on_signal
from q2q_model.commands.node_command_line import NodeCommandLine
from q2q_model.node.lean_imports import lean_imports

NO_FLAGS: Mapping[str, str] = MappingProxyType({})


def start_node(module: str, flags: Mapping[str, str] = NO_FLAGS) -> None:
    """Run `main` of a node's module; SIGINT and SIGTERM during its import exit with status 0, as later.

    Args:
        module: of the node; its docstring is the node's help.
        flags: see NodeCommandLine.
    """
    with exiting_on_signal(0), lean_imports():
        node = import_module(module)
    package, _, file = module.partition(".ros.")
    line = NodeCommandLine(package, file.removesuffix("_node"), node.__doc__, flags)
    sys.argv[1:] = line.for_ros(sys.argv[1:])
    node.main()
