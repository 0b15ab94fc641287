"""Start of a node: import of its module, which takes most of the start-up time, and call of its `main`."""

from importlib import import_module

from q2q_model.commands.quiet_end import ending_at_once
from q2q_model.node.lean_imports import lean_imports


def start_node(module: str) -> None:
    """Run `main` of a node's module; SIGINT and SIGTERM during its import exit with status 0, as later."""
    with ending_at_once(0), lean_imports():
        main = import_module(module).main
    main()
