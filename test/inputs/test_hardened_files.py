"""Nothing in a file can throw its reader out, and no file of ours runs code."""

import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from drawn_values import numbers, words
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.bag import BagError, BagReader
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.trajectory import plan_file
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_document import scenario_from_document

documents = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), numbers, words),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(words, inner, max_size=3)),
    max_leaves=8,
)


@st.composite
def spoiled_document(draw: st.DrawFn) -> object:
    """Draw a scenario with one value anywhere replaced by anything."""
    document = dict(library.document(draw(st.sampled_from(["table6_room", "stack3"]))))
    key = draw(st.sampled_from([*document, "faults", "vicon", "radio", "imu", "safe", ""]))
    value = document.get(key)
    if isinstance(value, dict) and draw(st.booleans()):
        value = dict(value)
        inner = draw(st.sampled_from([*value, "cf1"]))
        points = value.get(inner)
        if isinstance(points, list) and points and draw(st.booleans()):
            points = [dict(point) for point in points]
            points[0][draw(st.sampled_from(["t", "pos", "yaw", "x"]))] = draw(documents)
            value[inner] = points
        else:
            value[inner] = draw(documents)
        return document | {key: value}
    return document | {key: draw(documents)}


@settings(max_examples=300, deadline=None, derandomize=True)
@given(document=st.one_of(spoiled_document(), documents))
def test_a_scenario_with_anything_in_it_is_read_or_refused(document: object) -> None:
    with suppress(ValueError):  # and nothing else
        scenario_from_document("fuzzed", document)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(document=documents)
def test_waypoints_with_anything_in_them_are_read_or_refused(document: object) -> None:
    with suppress(ValueError):  # and nothing else
        swarm_from_document({"vehicles": document}, FlightLimits())


class Bomb:
    """Where this is unpickled, a file is made."""

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        """Return what unpickling calls."""
        return (Path.touch, (Path(BOMBED[0]),))


BOMBED: list[str] = [""]


@pytest.mark.parametrize("protocol", [0, 2, 5])
def test_no_file_of_ours_runs_code(protocol: int, tmp_path: Path) -> None:
    BOMBED[0] = str(tmp_path / "bombed")
    bomb = pickle.dumps(Bomb(), protocol)
    sys.modules.setdefault("test_hardened_files", sys.modules[Bomb.__module__])
    pickle.loads(bomb)  # noqa: S301  it is a bomb indeed
    assert Path(BOMBED[0]).exists()
    Path(BOMBED[0]).unlink()
    yaml_bomb = (
        f"!!python/object/apply:pathlib.Path.touch [!!python/object/apply:pathlib.Path ['{BOMBED[0]}']]"
    )
    for content in (bomb, yaml_bomb.encode()):
        for name, read, error in (
            ("model.q2q", lambda path: find_model(str(path)), ModelFileError),
            ("plan.json", plan_file.load, ValueError),
            ("scenario.yaml", lambda path: library.load(str(path)), ValueError),
            ("bag.mcap", BagReader, BagError),
        ):
            path = tmp_path / name
            path.write_bytes(content)
            with pytest.raises(error):
                read(path)
    assert not Path(BOMBED[0]).exists()
