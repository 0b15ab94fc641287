"""Rewrite the installed console scripts, so that they start at once and from any folder.

setuptools' own look their function up among all installed packages, a tenth of a second of it, and begin with
`#!"/a b/bin/python"` where the checkout's path has a space, which no kernel reads. pip's form of that line (a
shell line that Python reads as a string) works everywhere.
"""

import sys
from importlib.metadata import EntryPoint, PathDistribution
from pathlib import Path

MADE_BY_SETUPTOOLS = "load_entry_point"
MADE_HERE = '"""Start {}\'s '
LONGEST = 120
"""Longest path of an interpreter that every kernel takes from a first line."""
INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""
SCRIPT = '''{first}
"""Start {package}'s {name}."""

import os
import signal
import sys

interruptible = signal.getsignal(signal.SIGINT) is signal.default_int_handler
if interruptible:
    signal.signal(signal.SIGINT, lambda *_: os._exit({interrupted}))  # a traceback of imports says nothing
from {module} import {function}

if interruptible:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if __name__ == "__main__":
    sys.exit({function}())
'''
PLAIN = "#!{python}"
PORTABLE = """#!/bin/sh
'''exec' "{python}" "$0" "$@"
' '''"""


def rewrite(root: Path, python: str) -> None:
    """Rewrite the scripts `install/PKG/lib/PKG/EXE` of a checkout; remove those that no entry point has."""
    first = (PORTABLE if " " in python or len(python) > LONGEST else PLAIN).format(python=python)
    for info in (root / "build").glob("*/*.egg-info"):
        package = info.parts[-2]
        entries = {
            one.name: one for one in PathDistribution(info).entry_points.select(group="console_scripts")
        }
        for path in (root / "install" / package / "lib" / package).glob("*"):
            text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
            if path.name not in entries and (MADE_BY_SETUPTOOLS in text or MADE_HERE.format(package) in text):
                path.unlink()
            elif MADE_BY_SETUPTOOLS in text:
                path.write_text(_script(first, package, entries[path.name]), encoding="utf-8")


def _script(first: str, package: str, entry: EntryPoint) -> str:
    return SCRIPT.format(
        first=first,
        package=package,
        name=entry.name,
        module=entry.module,
        function=entry.attr,
        interrupted=INTERRUPTED,
    )


if __name__ == "__main__":
    rewrite(Path(sys.argv[1]), sys.executable)
