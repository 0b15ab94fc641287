"""Set-up fills the cache with every kernel, so that no flight compiles."""

import re
import subprocess
import sys

from fresh_checkout import ROOT

SOURCES = [path for path in (ROOT / "src").rglob("*.py") if "test" not in path.parts]
EVERY_KERNEL = """
from q2q_model.compiled import KERNELS, uncached
from q2q_sim.tools.compile_kernels import import_kernels
import_kernels()
print(len(KERNELS), *uncached(), sep="\\n")
"""


def run(script: str, *words: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_every_kernel_is_made_by_the_decorator_of_the_house() -> None:
    made = [source.name for source in SOURCES if re.search(r"\bn?jit\(", source.read_text())]
    assert made == ["compiled.py"]


def test_set_up_has_compiled_every_kernel() -> None:
    count, *missing = run(EVERY_KERNEL)
    assert int(count) > 100
    assert missing == [], "call them in q2q_sim.tools.kernel_calls"
