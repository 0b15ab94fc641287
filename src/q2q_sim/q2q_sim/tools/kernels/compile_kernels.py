"""Compilation of all kernels missing in the cache, on two cores: a step of scripts/setup.

Compilation in flight would stall the loop for seconds.
"""

import importlib
import pkgutil
import sys
from collections.abc import Iterator
from time import monotonic

from q2q_model.compiled import COMPILED, KERNELS, uncached_kernels
from q2q_sim.processes.worker_pool import worker_pool
from q2q_sim.q2q_packages import PACKAGES
from q2q_sim.tools.kernels.kernel_calls import calls

LEFT_OUT = (
    ".ros",
    ".tools",
    ".commands",
    ".launching",
    ".experiments",
    ".torch_training",
    ".explicit_mpc",
    ".program_process",
)
"""Parts of the packages that import ROS, torch or cflib, or whose kernels no flight calls."""
WORKERS = 2
"""Processes; a kernel that both call at once is compiled by both."""


def main() -> int:
    """Fill the cache; return the exit status, 1 if a kernel is never called or cannot be stored."""
    import_kernels()
    missing = uncached_kernels()
    if not missing:
        return 0
    began = monotonic()
    print(f"compiling {len(missing)} of {len(KERNELS)} kernels for this processor", flush=True)
    with worker_pool(WORKERS) as pool:
        made = set().union(*pool.map(make_call, range(len(calls()))))
    left = uncached_kernels()
    _tell_left(left, made)
    if left:
        return 1
    print(f"compiled in {monotonic() - began:.0f} s", flush=True)
    return 0


def import_kernels() -> None:
    """Import every module with kernels, so that KERNELS has all of them."""
    for name in _modules():
        importlib.import_module(name)


def make_call(number: int) -> set[str]:
    """Make one of the calls of kernels; return the names of all that this process has compiled."""
    calls()[number]()
    return set(COMPILED)


def _tell_left(left: list[str], made: set[str]) -> None:
    """Report the kernels that are not in the cache, in spite of those made."""
    for name in left:
        if name not in made:
            _report(f"{name} is never called: call it in q2q_sim.tools.kernels.kernel_calls")
    if lost := made.intersection(left):
        _report(
            f"compiled kernels that could not be stored: {len(lost)}; make room on the disk, or set "
            "NUMBA_CACHE_DIR to a writable folder"
        )


def _report(text: str) -> None:
    print(f"compile_kernels: {text}", file=sys.stderr)


def _modules() -> Iterator[str]:
    for package in PACKAGES:
        folders = importlib.import_module(package).__path__
        for found in pkgutil.walk_packages(folders, f"{package}."):
            if not any(f"{part}." in f"{found.name}." for part in LEFT_OUT):
                yield found.name


if __name__ == "__main__":
    sys.exit(main())
