"""Set-up fills the cache with every kernel, so that no flight compiles."""

import json
import re
import subprocess
import sys
from pathlib import Path

from fresh_checkout import ROOT

SOURCES = [path for path in (ROOT / "src").rglob("*.py") if "test" not in path.parts]
EVERY_KERNEL = """
from q2q_model.compiled import KERNELS, uncached
from q2q_sim.tools.compile_kernels import import_kernels
import_kernels()
print(len(KERNELS), *uncached(), sep="\\n")
"""
NOT_IN_FLIGHT = ["q2q_planner.offline.avoidance.separating_planes._descend"]
"""Called to plan ahead, for many vehicles."""


def run(*words: str) -> str:
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_kernel_is_made_by_the_decorator_of_the_house() -> None:
    made = [source.name for source in SOURCES if re.search(r"\bn?jit\(", source.read_text())]
    assert made == ["compiled.py"]


def test_set_up_has_compiled_every_kernel() -> None:
    count, *missing = run("-c", EVERY_KERNEL).split()
    assert int(count) > 100
    assert missing == [], "call them in q2q_sim.tools.kernel_calls"


def test_what_users_fly_calls_every_kernel_and_compiles_none() -> None:
    """A fresh process has the machine code of the set-up, and no other."""
    told = json.loads(run(str(Path(__file__).with_name("fresh_flights.py"))))
    assert told == {"compiled": [], "idle": NOT_IN_FLIGHT}
