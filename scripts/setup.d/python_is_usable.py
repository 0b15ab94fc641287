"""Print in one line why this Python cannot run q2q; print nothing and exit 0 if it can.

Run by every candidate interpreter, so it must parse on old ones.
"""

import os
import sys


def reason():  # noqa: ANN201 (old interpreters run this)
    """Return what is missing, or an empty string."""
    version = "%d.%d" % sys.version_info[:2]  # noqa: UP031 (old interpreters run this)
    if sys.version_info[:2] not in ((3, 11), (3, 12)):
        return "is Python " + version + ", not 3.11 or 3.12"
    try:
        import ensurepip  # noqa: F401
        import venv  # noqa: F401
    except ImportError:
        return "has no venv module: sudo apt install python" + version + "-venv"
    import sysconfig

    if not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")):  # noqa: PTH110, PTH118
        return "has no Python.h: sudo apt install python" + version + "-dev"
    return ""


if __name__ == "__main__":
    missing = reason()
    sys.stdout.write(missing)
    sys.exit(1 if missing else 0)
