"""Print the help of a tool before anything is set up: `tool_help.py MODULE`.

Run by any Python at hand, with nothing but its standard library; ends with TOO_OLD where it cannot.
"""

import sys

TOO_OLD = 3

if __name__ == "__main__":
    if sys.version_info < (3, 11):  # noqa: UP036 (any Python may run this)
        sys.exit(TOO_OLD)
    from importlib import import_module
    from pathlib import Path

    root = Path(__file__).resolve().parents[2]
    sys.path[:0] = [str(root / "benchmarks"), *map(str, sorted((root / "src").iterdir()))]
    sys.exit(import_module(sys.argv[1]).main(["--help"]))
