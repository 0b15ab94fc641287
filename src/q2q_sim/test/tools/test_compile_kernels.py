"""The step of the set-up that compiles kernels says of each that it leaves why it is not stored."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TWO_KERNELS = """
import resource
from concurrent.futures import ThreadPoolExecutor

from q2q_model.compiled import KERNELS, compiled
from q2q_sim.tools.kernels import compile_kernels


def called(x): return 0.5 * x
def never(x): return x / 3.0


KERNELS.clear()
half, third = compiled(called), compiled(never)
compile_kernels.import_kernels = lambda: None
compile_kernels.worker_pool = ThreadPoolExecutor
compile_kernels.calls = lambda: (lambda: half(3.0),)
resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, resource.RLIM_INFINITY))
raise SystemExit(compile_kernels.main())
"""
NEVER = "compile_kernels: __main__.never is never called: call it in q2q_sim.tools.kernels.kernel_calls"
NOT_STORED = (
    "compile_kernels: compiled kernels that could not be stored: 1; make room on the disk, or set "
    "NUMBA_CACHE_DIR to a writable folder"
)


@pytest.mark.parametrize(("room", "told"), [("resource.RLIM_INFINITY", [NEVER]), ("0", [NEVER, NOT_STORED])])
def test_kernels_that_cannot_be_stored_are_told_from_those_never_called(
    tmp_path: Path, room: str, told: list[str]
) -> None:
    """On a full disk every kernel was reported as never called."""
    script = tmp_path / "two_kernels.py"
    script.write_text(TWO_KERNELS.format(room=room))
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "PYTHONWARNINGS": "ignore"}
    done = subprocess.run(
        [sys.executable, "-B", str(script)], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.splitlines() == told


WITHOUT_OPTIONS = """
import sys
from importlib.abc import MetaPathFinder


class Absent(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"cflib", "torch", "foxglove", "cma", "dask", "distributed"}:
            raise ModuleNotFoundError(name=name)


sys.meta_path.insert(0, Absent())
from q2q_sim.tools.kernels.compile_kernels import import_kernels

import_kernels()
"""


def test_kernels_are_found_where_no_optional_package_is_installed() -> None:
    subprocess.run([sys.executable, "-c", WITHOUT_OPTIONS], check=True, capture_output=True, text=True)
