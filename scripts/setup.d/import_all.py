"""Import every module of the workspace: `import_all.py SRC`; packages that are optional may be missing."""

import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

for package in sorted(Path(sys.argv[1]).iterdir()):
    for source in sorted((package / package.name).rglob("*.py")):
        parts = source.relative_to(package).with_suffix("").parts
        with suppress(ImportError):
            import_module(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
