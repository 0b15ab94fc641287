"""Model, plan, air and scenario files are data: reading one, sound or hostile, imports and runs nothing."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from q2q_model.model_files.model_names import shipped_models
from q2q_model.trajectory import plan_file
from q2q_sim.air.air_names import air_path
from q2q_sim.loop import flight_blocks
from q2q_sim.scenarios import library

READERS = {
    ".q2q": "q2q_model.model_files.model_file",
    ".json": "q2q_model.trajectory.plan_file",
    ".air": "q2q_sim.air.air_file",
    ".yaml": "q2q_sim.scenarios.library",
}
READ = """
import importlib, json, sys
from pathlib import Path
readers = {end: importlib.import_module(name).load for end, name in json.loads(sys.argv[1]).items()}
import q2q_model.documents.plain_reader, q2q_sim.loop.flight_blocks
FORBIDDEN = ("import", "compile", "exec", "code.__new__", "marshal.", "pickle.", "os.system", "os.exec",
             "os.posix_spawn", "os.fork", "subprocess.", "ctypes.", "socket.")
seen, watching = [], False
def watch(event, arguments):
    if watching and event.startswith(FORBIDDEN):
        seen.append(f"{event} {arguments[0]!r}"[:200])
        raise PermissionError(event)
sys.addaudithook(watch)
def read(name):
    path = Path(name)
    try:
        readers[path.suffix](name if path.suffix == ".yaml" else path)
    except (ValueError, PermissionError) as refusal:
        return "refused" if isinstance(refusal, ValueError) else "forbidden"
    return "read"
sound, hostile = json.loads(sys.argv[2]), json.loads(sys.argv[3])
for name in sound:
    read(name)
watching = True
outcome = {name: read(name) for name in sound + hostile}
watching = False
print(json.dumps({"outcome": outcome, "seen": seen}))
"""
"""Reads files in a process whose audit hook (PEP 578) forbids to import and to execute code.

Sound files are read once before: cattrs then compiles converters of our own classes."""
HOSTILE = (
    "!!python/object/apply:os.system ['touch attacked']\n",
    "cos\nsystem\n(S'touch attacked'\ntR.",
    "__import__('os').system('touch attacked')",
    '{"format": "q2q model", "version": 4, "interaction": {"type": "os.system", "value": "touch attacked"}}',
    '{"format": "q2q-air", "version": 1, "air": "os:system"}',
    '{"format": "q2q_plan", "version": 1, "vehicles": [{"name": "a", "durations": "os.system"}]}',
)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[str], list[str]]:
    """Return sound files of every format, and hostile ones of every ending."""
    folder = tmp_path_factory.mktemp("files")
    plan = folder / "plan.json"
    plan_file.save(plan, flight_blocks.plan_of(library.load("table6")))
    shipped = [*shipped_models().glob("*.q2q"), *Path(library.__file__).parent.glob("*.yaml")]
    airs = [air_path("room")]
    hostile = [folder / f"hostile_{k}{end}" for k in range(len(HOSTILE)) for end in READERS]
    for path in hostile:
        path.write_text(HOSTILE[int(path.stem.partition("_")[2])])
    return [str(path) for path in (*shipped, *airs, plan)], [str(path) for path in hostile]


def _read(sound: list[str], hostile: list[str], folder: Path) -> tuple[dict[str, str], list[str]]:
    done = subprocess.run(
        [sys.executable, "-c", READ, *map(json.dumps, (READERS, sound, hostile))],
        cwd=folder,
        env=os.environ,
        capture_output=True,
        text=True,
        check=True,
    )
    answer = json.loads(done.stdout)
    return answer["outcome"], answer["seen"]


def test_files_are_read_where_imports_and_execution_are_forbidden(
    files: tuple[list[str], list[str]], tmp_path: Path
) -> None:
    sound, hostile = files
    outcome, seen = _read(sound, hostile, tmp_path)
    assert seen == []
    assert outcome == dict.fromkeys(sound, "read") | dict.fromkeys(hostile, "refused")
    assert list(tmp_path.iterdir()) == []
