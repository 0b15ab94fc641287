"""Refusal of processes of `multiprocessing`, in which cflib would look for real radios on the real clock."""

from multiprocessing.process import BaseProcess
from typing import NoReturn


def refuse_processes() -> None:
    """Let every start of a process fail for the rest of this process."""
    BaseProcess.start = _refuse  # type: ignore[assignment, method-assign]


def _refuse(_: BaseProcess) -> NoReturn:
    where = "the emulated vehicles are in this one; use threads"
    raise RuntimeError(f"a licence cannot start processes (multiprocessing): {where}")
