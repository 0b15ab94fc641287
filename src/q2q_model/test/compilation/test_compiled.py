"""Compiled code is kept, and that it is made again when anything it uses has changed."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO

import pytest
from numba import config
from numba.core.caching import FunctionCache

from q2q_model.compilation.kernel_cache import KernelIndex, warn_of_no_store
from q2q_model.compilation.kernel_digest import kernel_digest
from q2q_model.compiled import compiled, uncached_kernels

MAIN = """
from q2q_model.compiled import COMPILED, compiled
from callee import twice, OFFSET

def _run(x):
    return twice(x) + OFFSET

run = compiled(_run)
print(run(1.0), *COMPILED)
"""
CALLEE = """
from numba import njit
OFFSET = {offset}
def _twice(x):
    return {factor} * x
twice = njit(_twice)
"""


FORKS = """
import os, runpy, sys
from numba import config, njit
njit(lambda x: x)(0.0)  # what numba makes once in each process takes most of a second
for line in sys.stdin:
    folder = line.rstrip()
    if not (child := os.fork()):
        os.environ["NUMBA_CACHE_DIR"] = os.path.join(folder, "cache")
        config.reload_config()
        sys.path.insert(0, folder)
        runpy.run_path(os.path.join(folder, "main.py"), run_name="__main__")
        sys.stdout.flush()
        os._exit(0)
    print("status", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
"""Run scripts in copies of a process that has imported numba and nothing of ours."""


class _Interpreters:
    """Fresh interpreters, each in a process of its own."""

    def __init__(self, lines: IO[str], answers: IO[str]) -> None:
        self._lines, self._answers = lines, answers

    def printed(self, folder: Path, script: str) -> str:
        """Return what an interpreter prints that runs a script, whose file keeps its time."""
        main = folder / "main.py"
        if not main.exists() or main.read_text() != script:
            main.write_text(script)
            os.utime(main, (0, 0))  # numba's cache looks at the time; only the index's types shall differ
        print(folder, file=self._lines, flush=True)
        printed = []
        while not (line := self._answers.readline()).startswith("status "):
            assert line, "the process that is copied has ended"
            printed.append(line)
        assert line == "status 0\n", printed
        return "".join(printed).strip()

    def answer(self, folder: Path, factor: float, offset: float) -> str:
        """Return what an interpreter prints: the result, and what it compiled."""
        (folder / "callee.py").write_text(CALLEE.format(factor=factor, offset=offset))
        return self.printed(folder, MAIN)


@pytest.fixture(scope="module")
def fresh() -> Iterator[_Interpreters]:
    """Return fresh interpreters."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-B", "-c", FORKS]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, env=environment, text=True, **pipes) as forks:
        assert forks.stdin is not None
        assert forks.stdout is not None
        yield _Interpreters(forks.stdin, forks.stdout)


def test_code_is_kept_and_loaded_until_a_function_or_constant_elsewhere_changes(
    fresh: _Interpreters,
    tmp_path: Path,
) -> None:
    assert fresh.answer(tmp_path, 2.0, 0.5) == "2.5 __main__._run callee._twice"
    assert fresh.answer(tmp_path, 2.0, 0.5) == "2.5"
    assert fresh.answer(tmp_path, 3.0, 0.5) == "3.5 __main__._run callee._twice"
    assert fresh.answer(tmp_path, 3.0, 0.7) == "3.7 __main__._run callee._twice"
    assert fresh.answer(tmp_path, 2.0, 0.5) == "2.5"


def test_the_key_is_the_same_in_every_process() -> None:
    """Sets are written in another order by every process: kernels with such options were compiled again."""
    script = """
from numba import njit
from q2q_model.compilation.kernel_digest import kernel_digest
from q2q_model.compiled import compiled
inner = njit(lambda x: x in {"a", "b", "c"})
fast = njit(lambda x: x in {"a", "b", "c"}, fastmath={"contract", "reassoc", "nsz"})
def outer(x):
    return inner(x)
def outer_fast(x):
    return fast(x)
print(kernel_digest(outer), kernel_digest(outer_fast))
"""
    digests = set()
    for seed in ("1", "2", "3", "4"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", script]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        digests.add(done.stdout)
    (both,) = digests
    assert len(set(both.split())) == 2


def test_recursion_does_not_go_on_for_ever() -> None:
    def down(n: int) -> int:
        return 0 if n == 0 else down(n - 1)

    assert len(kernel_digest(down)) == 64


def test_where_numba_is_switched_off_a_kernel_is_the_function_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(config, "DISABLE_JIT", True)
    monkeypatch.setattr("q2q_model.compiled.KERNELS", [])
    assert compiled(_half)(3.0) == 1.5


def _half(x: float) -> float:
    return 0.5 * x


def test_code_of_types_whose_module_has_moved_is_compiled_anew(fresh: _Interpreters, tmp_path: Path) -> None:
    pair = "from typing import NamedTuple\nclass Pair(NamedTuple):\n    a: float\n"
    (tmp_path / "pair.py").write_text(pair)
    script = """
from q2q_model.compiled import COMPILED, compiled
from {module} import Pair
print(compiled(lambda pair: 2.0 * pair.a)(Pair(1.5)), len(COMPILED))
"""
    assert fresh.printed(tmp_path, script.format(module="pair")) == "3.0 1"
    assert fresh.printed(tmp_path, script.format(module="pair")) == "3.0 0"
    (tmp_path / "pair.py").rename(tmp_path / "couple.py")
    assert fresh.printed(tmp_path, script.format(module="couple")) == "3.0 1"


def test_code_that_calls_a_kernel_whose_module_has_moved_is_compiled_anew(
    fresh: _Interpreters, tmp_path: Path
) -> None:
    (tmp_path / "callee.py").write_text(
        "from q2q_model.compiled import compiled\n@compiled\ndef half(x):\n    return 0.5 * x\n"
    )
    script = """
from exported import half
from q2q_model.compiled import COMPILED, compiled
print(compiled(lambda x: half(x) + 1.0)(3.0), len(COMPILED) > 0)
"""
    (tmp_path / "exported.py").write_text("from callee import half")
    assert fresh.printed(tmp_path, script) == "2.5 True"
    assert fresh.printed(tmp_path, script) == "2.5 False"
    (tmp_path / "callee.py").rename(tmp_path / "moved.py")
    (tmp_path / "exported.py").write_text("from moved import half")
    assert fresh.printed(tmp_path, script) == "2.5 True"


def test_code_that_several_save_at_once_is_kept_of_all(tmp_path: Path) -> None:
    """Set-up compiles in two processes: what the slower one had not read was dropped, and made in flight."""

    def save(number: int) -> None:
        KernelIndex(str(tmp_path), "half", "of one source").save((number,), number)

    with ThreadPoolExecutor(4) as several:
        list(several.map(save, range(80)))
    index = KernelIndex(str(tmp_path), "half", "of one source")
    assert [index.load((number,)) for number in range(80)] == list(range(80))


HALF = """
from q2q_model.compiled import COMPILED, compiled, uncached_kernels
half = compiled(lambda x: 0.5 * x)
print(len(uncached_kernels()), half(3.0), len(COMPILED))
"""


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_cache_file_that_was_cut_short_is_written_anew(
    fresh: _Interpreters, tmp_path: Path, suffix: str
) -> None:
    """A full disk or a loss of power leaves such files: every start ended in a traceback."""
    assert fresh.printed(tmp_path, HALF) == "1 1.5 1"
    (file,) = (tmp_path / "cache").glob(f"*/*.{suffix}")
    file.write_bytes(file.read_bytes()[:-100] if suffix == "nbc" else b"")
    assert fresh.printed(tmp_path, HALF).endswith(" 1.5 1")
    assert fresh.printed(tmp_path, HALF) == "0 1.5 0"


NOT_STORED = (
    "machine code cannot be stored, so every start compiles it: set NUMBA_CACHE_DIR to a writable folder"
)
FULL_DISK = """
import resource, warnings
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("default")
    from q2q_model.compiled import COMPILED, compiled, uncached_kernels
    half, third = compiled(lambda x: 0.5 * x), compiled(lambda x: x / 3.0)
    print(len(uncached_kernels()), half(3.0), third(3.0), len(COMPILED), *[one.message for one in said])
"""


@pytest.mark.parametrize("limit", [0, 4096])  # none or only the index has space
def test_on_a_full_disk_kernels_are_compiled_at_each_start(
    fresh: _Interpreters, tmp_path: Path, limit: int
) -> None:
    for _ in range(2):
        said = fresh.printed(tmp_path, FULL_DISK.format(limit=limit))
        assert said == f"2 1.5 1.0 2 {NOT_STORED}"


def test_without_a_folder_for_machine_code_kernels_are_compiled_at_each_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_folder(_: object, __: object) -> None:
        raise RuntimeError("cannot cache function '_half': no locator available for file 'half.py'")

    warn_of_no_store.cache_clear()
    monkeypatch.setattr(FunctionCache, "__init__", no_folder)
    monkeypatch.setattr("q2q_model.compiled.KERNELS", [])
    with pytest.warns(RuntimeWarning, match="set NUMBA_CACHE_DIR to a writable folder"):
        assert compiled(_half)(3.0) == 1.5
    assert uncached_kernels() == [f"{__name__}._half"]


READ_ONLY = """
import ctypes, warnings
version, of_this_process, none = 0x20080522, 0, [0] * 6
words = ctypes.c_uint32 * 2, ctypes.c_uint32 * 6
assert ctypes.CDLL(None).capset(words[0](version, of_this_process), words[1](*none)) == 0
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("default")
    from q2q_model.compiled import COMPILED, compiled, uncached_kernels
    half = compiled(lambda x: 0.5 * x)
    print(len(uncached_kernels()), half(3.0), len(COMPILED), *[one.message for one in said])
"""
"""Without capabilities, permissions hold for root, too."""


def test_code_is_loaded_from_a_folder_that_can_only_be_read(fresh: _Interpreters, tmp_path: Path) -> None:
    """Whoever ran the installation of another user compiled for minutes at each start."""
    assert fresh.printed(tmp_path, READ_ONLY) == "1 1.5 1"
    (folder,) = (tmp_path / "cache").iterdir()
    kept = sorted(folder.iterdir())
    folder.chmod(0o555)
    assert fresh.printed(tmp_path, READ_ONLY) == "0 1.5 0"
    (index,) = folder.glob("*.nbi")
    index.chmod(0)
    assert fresh.printed(tmp_path, READ_ONLY) == f"1 1.5 1 {NOT_STORED}"
    assert sorted(folder.iterdir()) == kept


PAIR = """
from typing import NamedTuple
class Pair(NamedTuple):
    {}: float
    {}: float
"""


FIELDS = """
from pair import Pair
from q2q_model.compiled import COMPILED, compiled, uncached_kernels
given = compiled(lambda pair: pair.a - 10.0 * pair.b)
nested = compiled(lambda rows: rows[0].a - 10.0 * rows[0].b)
made = compiled(lambda a: Pair(a=a, b=2.0)[0] - 10.0 * Pair(a=a, b=2.0)[1])
uncached = len(uncached_kernels())
pair = Pair(a=1.0, b=2.0)
print(uncached, given(pair), nested((pair, 0.0)), made(1.0), len(COMPILED))
"""


def test_code_is_compiled_anew_for_fields_in_another_order(fresh: _Interpreters, tmp_path: Path) -> None:
    """Code reads fields by index, and numba's key holds only their types: it read the other field."""
    (tmp_path / "pair.py").write_text(PAIR.format("a", "b"))
    assert fresh.printed(tmp_path, FIELDS) == "3 -19.0 -19.0 -19.0 3"
    assert fresh.printed(tmp_path, FIELDS) == "0 -19.0 -19.0 -19.0 0"
    (tmp_path / "pair.py").write_text(PAIR.format("b", "a"))
    assert fresh.printed(tmp_path, FIELDS) == "3 -19.0 -19.0 -8.0 3"
