"""Fuzz the file readers with Atheris, which follows their branches: each reads a file, or refuses it.

    python test/fuzz_readers.py {bag,model,plan,scenario,waypoints,cdr} FOLDER [options of libFuzzer]
    python test/fuzz_readers.py bag out/fuzz -max_total_time=120

FOLDER/READER holds the corpus, which begins with good files. A reader may raise what it documents; anything
else ends the run, and the input is left as crash-*. Not a test that pytest collects: it has no end.
Needs requirements/fuzz.txt.
"""

import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp

os.environ["NUMBA_DISABLE_JIT"] = "1"  # instrumented bytecode is not for numba

import atheris
import numpy as np

with atheris.instrument_imports(include=["q2q_model", "q2q_planner", "q2q_sim", "yaml", "rosbags"]):
    from q2q_model.bag import BagError, BagReader, BagWriter
    from q2q_model.documents.checksummed_json import checksum
    from q2q_model.model_files import model_file
    from q2q_model.model_files.find_model import find_model
    from q2q_model.node.warm_up import synthetic_signal
    from q2q_model.signals.cdr.cdr_reader import decode
    from q2q_model.signals.cdr.cdr_writer import encode
    from q2q_model.signals.layout import LAYOUTS
    from q2q_model.trajectory import plan_file
    from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
    from q2q_planner.tools.waypoint_file import read_waypoints
    from q2q_sim.loop import flight_blocks
    from q2q_sim.scenarios import library

ROOT = Path(__file__).parents[1]
SCRATCH = Path(mkdtemp(prefix="q2q-fuzz-"))
SCENARIO = (ROOT / "test" / "scenarios" / "short_room.yaml").read_text(encoding="utf-8")


def written(data: bytes, name: str) -> Path:
    """Return a file with these bytes."""
    path = SCRATCH / name
    path.write_bytes(data)
    return path


def bag(data: bytes) -> None:
    """Read all signals of a bag."""
    path = written(data, "bag.mcap")
    with suppress(BagError):
        for _ in BagReader(path).signals():
            pass


def model(data: bytes) -> None:
    """Read a model file as it stands, and once more with a checksum that fits."""
    with suppress(model_file.ModelFileError):
        find_model(str(written(data, "model.q2q")))
    with suppress(ValueError, RecursionError):
        body = json.loads(data)
        if isinstance(body, dict):
            body.pop("checksum", None)
            body["checksum"] = checksum(body)  # which is not what is tested
            data = json.dumps(body).encode()
    with suppress(model_file.ModelFileError):
        find_model(str(written(data, "model.q2q")))


def plan(data: bytes) -> None:
    """Read a plan file."""
    with suppress(ValueError):
        plan_file.load(written(data, "plan.json"))


def scenario(data: bytes) -> None:
    """Read a scenario."""
    with suppress(ValueError):
        library.load(str(written(data, "scenario.yaml")))


def waypoints(data: bytes) -> None:
    """Read waypoints."""
    with suppress(ValueError):
        read_waypoints(written(data, "waypoints.yaml"), FlightLimits(), "stop_and_go")


def cdr(data: bytes) -> None:
    """Read a message as one of every kind; what can be read is written and read again the same."""
    for kind in LAYOUTS:
        with suppress(ValueError):
            found = decode(data, kind)
            again = decode(encode(found, 0), kind)
            for name in (column.attribute for column in LAYOUTS[kind].columns):
                np.testing.assert_array_equal(getattr(again, name), getattr(found, name))


def small_bag() -> bytes:
    """Return a bag with a message of every kind, small enough to be mutated often."""
    folder = SCRATCH / "small"
    with BagWriter(folder) as made:
        for kind, layout in LAYOUTS.items():
            made.write_signal(f"/{layout.message}", 10**9, synthetic_signal(kind, 1.0, ("cf1",)))
    return next(folder.glob("*.mcap")).read_bytes()


def good_files() -> dict[str, list[bytes]]:
    """Return what each reader's corpus begins with."""
    table2 = flight_blocks.plan_of(library.load("table6"))
    rows = SCENARIO[SCENARIO.index("vehicles:") :]
    return {
        "bag": [small_bag()],
        "model": [path.read_bytes() for path in (ROOT / "src/q2q_model/config").glob("*.q2q")],
        "plan": [plan_file.encode(table2).encode()],
        "scenario": [SCENARIO.encode()],
        "waypoints": [rows.encode()],
        "cdr": [encode(synthetic_signal(kind, 1.0, ("cf1", "cf2")), 10**9) for kind in LAYOUTS],
    }


READERS: dict[str, Callable[[bytes], None]] = {
    "bag": bag, "model": model, "plan": plan, "scenario": scenario, "waypoints": waypoints, "cdr": cdr,
}  # fmt: skip


def main() -> None:
    """Fuzz one reader until it breaks, or libFuzzer's options end it."""
    if len(sys.argv) < 3 or sys.argv[1] not in READERS:
        raise SystemExit(__doc__)
    name, corpus = sys.argv[1], Path(sys.argv[2]) / sys.argv[1]
    corpus.mkdir(parents=True, exist_ok=True)
    for index, data in enumerate(good_files()[name]):
        (corpus / f"good{index}").write_bytes(data)
    options = [f"-artifact_prefix={corpus.parent}/", *sys.argv[3:]]
    atheris.Setup([sys.argv[0], str(corpus), *options], READERS[name])
    atheris.Fuzz()


if __name__ == "__main__":
    main()
