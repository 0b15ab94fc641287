"""Set-up fills the cache with every kernel, so that no flight compiles."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

from fresh_checkout import ROOT

SOURCES = [path for path in (ROOT / "src").rglob("*.py") if "test" not in path.parts]
EVERY_KERNEL = """
from q2q_model.compiled import KERNELS, uncached_kernels
from q2q_sim.tools.kernels.compile_kernels import import_kernels
import_kernels()
print(len(KERNELS), *uncached_kernels(), sep="\\n")
"""


PLAIN = str(Path(__file__).parents[1].joinpath("plain_kernels.py"))
ROUNDING = 1e-9
"""Fast sums add in another order: rounding grown through recursions of 40 stages."""


def run(*words: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=1800,
        env=os.environ | environment,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_kernel_is_made_by_the_decorator_of_the_house() -> None:
    made = [source.name for source in SOURCES if re.search(r"\bn?jit\(", source.read_text())]
    assert made == ["compiled.py"]


def test_set_up_has_compiled_every_kernel() -> None:
    count, *missing = run("-c", EVERY_KERNEL).split()
    assert int(count) > 100
    assert missing == [], "call them in q2q_sim.tools.kernels.kernel_calls"


def test_what_users_fly_calls_every_kernel_and_compiles_none() -> None:
    """A fresh process has the machine code of the set-up and no other, of one layout for each kernel."""
    output = json.loads(run(str(Path(__file__).parents[1].joinpath("fresh_flights.py"))))
    assert output == {"compiled": [], "idle": [], "twice": []}


def test_every_kernel_computes_what_its_plain_form_does(tmp_path: Path) -> None:
    entries = json.loads(run(PLAIN, "record", str(tmp_path / "calls")))
    differences = json.loads(run(PLAIN, "compare", str(tmp_path / "calls"), NUMBA_DISABLE_JIT="1"))
    assert sorted(differences) == sorted(entries), "call them in q2q_sim.tools.kernels.kernel_calls"
    assert {name: size for name, size in differences.items() if not size < ROUNDING} == {}
