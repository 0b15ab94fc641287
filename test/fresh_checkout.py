"""A fresh checkout for the tests of the set-up: the scripts, no .venv, a bare machine's environment."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BASE_PYTHON = Path(sys.base_prefix, "bin", f"python3.{sys.version_info.minor}")
"""The interpreter that .venv was made from."""


@dataclass(frozen=True, slots=True)
class Checkout:
    """A checkout, the tools that only it sees, and its environment."""

    root: Path
    bin: Path
    """First on PATH: tools put here stand before the system's."""
    env: dict[str, str]

    def tool(self, name: str, script: str) -> None:
        """Put a shell script on PATH."""
        path = self.bin / name
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)

    def hide(self, *names: str) -> None:
        """Rebuild PATH from links to every system tool but those whose names start so."""
        for folder in ("/usr/bin", "/bin"):
            for tool in Path(folder).iterdir():
                link = self.bin / tool.name
                if not tool.name.startswith(names) and not link.exists():
                    link.symlink_to(tool)
        self.env["PATH"] = str(self.bin)

    def setup(self, *arguments: str, **changes: str) -> subprocess.CompletedProcess[str]:
        """Run scripts/setup to its end."""
        command = [str(self.root / "scripts/setup"), *arguments]
        return subprocess.run(command, env=self.env | changes, capture_output=True, text=True, check=False)

    def shell(self, script: str, **changes: str) -> subprocess.CompletedProcess[str]:
        """Run a bash script in the checkout."""
        return subprocess.run(
            ["bash", "-c", script],
            cwd=self.root,
            env=self.env | changes,
            capture_output=True,
            text=True,
            check=False,
        )
