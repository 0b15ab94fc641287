"""Rewrite the Python folders that the ROS wheels' CMake exports name to those of this interpreter.

The wheels were built in a container, so `share/*/cmake/*Export*.cmake` names `/opt/python/cpXY-cpXY/...`, and
CMake refuses targets whose include folders do not exist. Idempotent: a repaired file names no such folder.
"""

import re
import sys
import sysconfig
from pathlib import Path

INCLUDE = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")
SITE_PACKAGES = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages")


def repaired(text: str) -> str:
    """Return the CMake text with the folders of this interpreter."""
    paths = sysconfig.get_paths()
    text = INCLUDE.sub(lambda _: paths["include"], text)
    return SITE_PACKAGES.sub(lambda _: paths["purelib"], text)


def repair(prefix: Path) -> int:
    """Repair every export file under the prefix and return how many changed."""
    count = 0
    for path in prefix.glob("share/*/cmake/*.cmake"):
        text = path.read_text(encoding="utf-8")
        if (new := repaired(text)) != text:
            path.write_text(new, encoding="utf-8")
            count += 1
    return count


if __name__ == "__main__":
    sys.stdout.write(f"{repair(Path(sys.prefix))} CMake files repaired\n")
