"""Run of an area in a process of its own, so that a failure, or what it leaves behind, reaches no other area.

The process is `bench.py AREA --json FILE` of this checkout, or `scripts/bench AREA --json FILE` of another.
"""

import json
import math
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO

from row import Row

COLUMNS = tuple(field.name for field in fields(Row))


class AreaError(Exception):
    """Area without rows, in one sentence."""


@dataclass(frozen=True, slots=True)
class Bench:
    """Benchmarks of a checkout."""

    command: Sequence[str]
    """Area and `--json FILE` follow."""
    environment: Mapping[str, str] | None = None
    """None is that of this process."""
    tables: bool = True
    """Show its tables."""
    notes: bool = True
    """Show what else it says; if not, the last line of that is in an AreaError."""

    def rows(self, area: str) -> list[Row]:
        """Run an area; return its rows. Raises AreaError."""
        with TemporaryDirectory() as folder:
            file, log = Path(folder) / "rows.json", Path(folder) / "log"
            with log.open("wb") as notes:
                status = self._ended([area, "--json", str(file)], None if self.notes else notes)
            if status:
                raise AreaError(f"{area} failed with status {status}{_last_line(log)}")
            return read_rows(file)

    def _ended(self, words: Sequence[str], notes: IO[bytes] | None) -> int:
        """Return the exit status of the command with these words, in a process that dies with this one."""
        from q2q_sim.processes.parent_death import die_with_parent

        with subprocess.Popen(
            [*self.command, *words],
            env=self.environment,
            stdout=None if self.tables else subprocess.DEVNULL,
            stderr=notes,
            preexec_fn=die_with_parent,  # noqa: PLW1509 (no threads here)
        ) as process:
            try:
                return process.wait()
            except KeyboardInterrupt:  # the terminal names the area, too
                process.wait()
                raise


def read_rows(file: Path) -> list[Row]:
    """Return the rows of a `--json` file, of any version; a value of null is NaN. Raises AreaError."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        rows = [Row(**{name: one[name] for name in COLUMNS if name in one}) for one in found]
    except (OSError, ValueError, TypeError) as error:
        raise AreaError(f"{file.name} cannot be read: {error}") from error
    return [replace(row, value=_number(row.value)) for row in rows]


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _last_line(log: Path) -> str:
    lines = log.read_text(errors="replace").split("\n")
    said = [line.strip() for line in lines if line.strip()]
    return f": {said[-1]}" if said else ""
