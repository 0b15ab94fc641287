"""Memory, handles and threads of a running process, from /proc."""

import os
from dataclasses import dataclass
from pathlib import Path

PAGE = os.sysconf("SC_PAGE_SIZE")
"""[bytes]"""


@dataclass(frozen=True, slots=True)
class ProcessUsage:
    """What a process holds."""

    memory: int
    """Resident set [bytes]."""
    handles: int
    """Open file descriptors."""
    threads: int


def usage_of(pid: int) -> ProcessUsage:
    """Return what a process holds; raise OSError if it has ended."""
    process = Path("/proc") / str(pid)
    return ProcessUsage(
        memory=PAGE * int((process / "statm").read_text().split()[1]),
        handles=sum(1 for _ in (process / "fd").iterdir()),
        threads=sum(1 for _ in (process / "task").iterdir()),
    )
