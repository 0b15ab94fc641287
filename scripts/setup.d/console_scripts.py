"""Write the installed console scripts anew, so that they start at once and from any folder.

setuptools' own look their function up among all installed packages, a tenth of a second of it, and begin with
`#!"/a b/bin/python"` where the checkout's path has a space, which no kernel reads. pip's form of that line (a
shell line that Python reads as a string) works everywhere.
"""

import sys
from configparser import ConfigParser
from pathlib import Path

MADE_BY_SETUPTOOLS = "load_entry_point"
LONGEST = 120
"""Longest path of an interpreter that every kernel takes from a first line."""
SCRIPT = '''{first}
"""Start {package}'s {name}."""

import sys

from {module} import {function}

if __name__ == "__main__":
    sys.exit({function}())
'''
PLAIN = "#!{python}"
PORTABLE = """#!/bin/sh
'''exec' "{python}" "$0" "$@"
' '''"""


def rewrite(root: Path, python: str) -> None:
    """Rewrite the scripts `install/PKG/lib/PKG/EXE` of a checkout's packages."""
    first = (PORTABLE if " " in python or len(python) > LONGEST else PLAIN).format(python=python)
    for listed in (root / "build").glob("*/*.egg-info/entry_points.txt"):
        package = listed.parts[-3]
        for name, target in _entries(listed).items():
            path = root / "install" / package / "lib" / package / name
            if path.is_file() and MADE_BY_SETUPTOOLS in path.read_text(encoding="utf-8"):
                module, _, function = target.partition(":")
                text = SCRIPT.format(
                    first=first, package=package, name=name, module=module, function=function
                )
                path.write_text(text, encoding="utf-8")


def _entries(listed: Path) -> dict[str, str]:
    """Return the console scripts of an entry_points.txt: name -> module:function."""
    parser = ConfigParser(delimiters=("=",))
    parser.read(listed, encoding="utf-8")
    return dict(parser["console_scripts"]) if parser.has_section("console_scripts") else {}


if __name__ == "__main__":
    rewrite(Path(sys.argv[1]), sys.executable)
