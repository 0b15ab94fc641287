"""Compilation of all kernels missing in the cache, on two cores: a step of scripts/setup.

Compilation in flight would stall the loop for seconds.
"""

import importlib
import pkgutil
import sys
from collections.abc import Iterator
from time import monotonic

from q2q_model.compiled import KERNELS, uncached_kernels
from q2q_sim.processes.worker_pool import worker_pool
from q2q_sim.tools.kernel_calls import calls

PACKAGES = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim")
NOT_PURE = (".ros", ".tools", ".commands", ".launching", ".experiments", ".torch_training")
"""Parts of the packages without kernels that import ROS or torch."""
WORKERS = 2
"""Processes; a kernel that both call at once is compiled by both."""


def main() -> int:
    """Fill the cache; return the exit status, 1 if a kernel is never called."""
    import_kernels()
    missing = uncached_kernels()
    if not missing:
        return 0
    began = monotonic()
    print(f"compiling {len(missing)} of {len(KERNELS)} kernels for this processor", flush=True)
    with worker_pool(WORKERS) as pool:
        list(pool.map(make_call, range(len(calls()))))
    left = uncached_kernels()
    for name in left:
        print(
            f"compile_kernels: {name} is never called: call it in q2q_sim.tools.kernel_calls", file=sys.stderr
        )
    if left:
        return 1
    print(f"compiled in {monotonic() - began:.0f} s", flush=True)
    return 0


def import_kernels() -> None:
    """Import every module with kernels, so that KERNELS has all of them."""
    for name in _modules():
        importlib.import_module(name)


def make_call(number: int) -> None:
    """Make one of the calls of kernels."""
    calls()[number]()


def _modules() -> Iterator[str]:
    for package in PACKAGES:
        folders = importlib.import_module(package).__path__
        for found in pkgutil.walk_packages(folders, f"{package}."):
            if not any(f"{part}." in f"{found.name}." for part in NOT_PURE):
                yield found.name


if __name__ == "__main__":
    sys.exit(main())
