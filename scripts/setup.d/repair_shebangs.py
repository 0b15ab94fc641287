"""Make installed console scripts start where the checkout's path has a space.

setuptools writes `#!"/a b/bin/python"`, which no kernel reads; pip's own form (a shell line that Python reads
as a string) works everywhere.
"""

import re
import sys
from pathlib import Path

QUOTED = re.compile(rb'\A#!"(?P<python>[^"\n]+)"[^\n]*\n')
PORTABLE = rb"""#!/bin/sh
'''exec' "\g<python>" "$0" "$@"
' '''
"""


def repair(install: Path) -> None:
    """Rewrite the first line of every script of `install/PKG/lib/PKG/` that quotes its interpreter."""
    for path in install.glob("*/lib/*/*"):
        if path.is_file() and path.parent.name == path.parents[2].name:
            text = path.read_bytes()
            if (new := QUOTED.sub(PORTABLE, text)) != text:
                path.write_bytes(new)


if __name__ == "__main__":
    repair(Path(sys.argv[1]))
