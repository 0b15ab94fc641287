"""A waypoint file that cannot be flown is refused in one line that names vehicle, waypoint and bound."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_planner.commands.plan import main
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.tools.waypoint_file import read_waypoints

LIMITS = FlightLimits()
TWO = "vehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 5, pos: [1, 0, 1]}], cf2: [{t: 0, pos: [0, 3, 1]}, LAST]}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file: got None, expected a mapping with vehicles"),
        ("nothing: 1", "the file: vehicles is missing"),
        ("vehicles:", "the file: vehicles = None; must be {name: waypoints}, such as {cf1: ["),
        ("vehicles: {}", "no vehicle given; must be at least 1"),
        ("vehicles: [", "is not valid YAML: line 1: expected the node content, but found '<stream end>'"),
        ("a: b: c", "is not valid YAML: line 1: mapping values are not allowed here"),
        ("\tvehicles: 1", "is not valid YAML: line 1: found character '\\t' that cannot start any token"),
        ("!!python/object:os.system {}", "is not valid YAML: line 1: could not determine a constructor"),
        ("[" * 5000, "is nested too deeply"),
        ("vehicles: !!bool x", "is not valid YAML: 'x'"),
        ("&a {vehicles: *a}", "is not valid YAML: line 1: more than 1000000 values"),
        (TWO.replace("LAST", "{t: 5, pos: [1, 3, 1]}").replace("cf2", "cf1"), "line 1: duplicate key 'cf1'"),
        (
            TWO.replace("LAST", "{t: 5, pos: [.inf, 3, 1]}"),
            "cf2, waypoint 1: pos[0] = inf; must be a finite number",
        ),
        (
            TWO.replace("LAST", "{t: 5, pos: [1, -.inf, 1]}"),
            "cf2, waypoint 1: pos[1] = -inf; must be a finite number",
        ),
        (
            TWO.replace("LAST", "{t: 5, pos: [1, 3, .nan]}"),
            "cf2, waypoint 1: pos[2] = nan; must be a finite number",
        ),
        (
            TWO.replace("LAST", "{t: 5, pos: [1, 3, 1], yaw: .nan}"),
            "cf2, waypoint 1: yaw = nan; must be a finite number",
        ),
        (
            TWO.replace("LAST", "{t: 5, pos: [1, 3, 1], yaw: 90}"),
            "cf2, waypoint 1: yaw 90 rad is 90 rad from the previous one, maximum one turn (6.283)",
        ),
        (
            TWO.replace("LAST", "{t: .inf, pos: [1, 3, 1]}"),
            "cf2, waypoint 1: t = inf; must be a finite number",
        ),
        (TWO.replace("LAST", "{t: 1.0e+6, pos: [1, 3, 1]}"), "t = 1e+06; must be in [-100000, 100000]"),
        (TWO.replace("LAST", "{t: 5, pos: [1.0e+5, 3, 1]}"), "x = 100000; must be in [-10000, 10000]"),
        (TWO.replace("LAST", "{t: 5, pos: [1" + "0" * 400 + ", 3, 1]}"), "cf2, waypoint 1: pos[0] = 1000"),
        (TWO.replace("LAST", "{t: 0, pos: [1, 3, 1]}"), "cf2, waypoint 1: t = 0.0 s coincides"),
        (TWO.replace("LAST", "{t: -1, pos: [1, 3, 1]}"), "cf2, waypoint 1: t = -1.0 s is before"),
        (TWO.replace(", LAST", ""), "cf2: 1 waypoint(s) given; must be at least 2"),
        (
            TWO.replace("LAST", "{t: 5, pos: [1, 3]}"),
            "cf2, waypoint 1: pos = [1, 3]; must be [x, y, z] in metres",
        ),
        (TWO.replace("LAST", "{t: true, pos: [1, 3, 1]}"), "cf2, waypoint 1: t = True; must be a number"),
        (
            TWO.replace("LAST", "{pos: [1, 3, 1]}"),
            "cf2, waypoint 1: t is missing: give all",
        ),
        (TWO.replace("LAST", "7"), "cf2, waypoint 1: got 7, expected a mapping with pos, t, yaw"),
        (
            "vehicles: {../cf1: []}",
            "vehicle '../cf1': a name must be a letter followed by letters, digits and _",
        ),
        (
            "vehicles: {cf1: [{pos: [0, 0, 1]}, {pos: [.nan, 0, 1]}]}",
            "cf1, waypoint 1: pos[0] = nan; must be a finite number",
        ),
        ("vehicles: {cf1: [{pos: [0, 0, 1]}, {pos: [1.0e+99, 0, 1]}]}", "cf1, waypoint 1: x = 1e+99"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "bad.yaml", tmp_path / "plan.json"
    path.write_text(text)
    assert main([str(path), "--out", str(out)]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"plan: {path}: ")
    assert message in error
    assert error.count("\n") == 1
    assert not out.exists()


def test_a_file_of_bytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bytes.yaml"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(ValueError, match=r"bytes\.yaml: cannot be read \(not UTF-8"):
        read_waypoints(path, LIMITS, "stop_and_go")


Rows = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["vehicles", "cf1", "cf2", "t", "pos", "yaw", "x y", ""]), inner, max_size=4
        )
    ),
    max_leaves=20,
)
Numbers = st.integers(-3, 20) | st.floats() | st.integers()
Points = st.fixed_dictionaries(
    {"pos": st.lists(Numbers, min_size=3, max_size=3)}, optional={"t": Numbers, "yaw": Numbers}
)
Nearly = st.fixed_dictionaries(
    {"vehicles": st.dictionaries(st.sampled_from(["cf1", "cf2"]), st.lists(Points, max_size=4), max_size=2)}
)


@settings(deadline=None, max_examples=150)
@given(Rows | Nearly)
def test_any_document_is_read_or_refused_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, document: object
) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "any.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    assert_read_or_refused(path)


@settings(deadline=None, max_examples=150)
@given(st.text(alphabet=st.sampled_from("vehicles: {}[]&*!|>-'\"\n\t#,cf1t0pos.e%@`"), max_size=80))
def test_any_text_is_read_or_refused_in_one_line(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "any.yaml"
    path.write_text(text, encoding="utf-8")
    assert_read_or_refused(path)


def assert_read_or_refused(path: Path) -> None:
    swarm: tuple[VehicleWaypoints, ...] = ()
    message = ""
    try:
        swarm = read_waypoints(path, LIMITS, "stop_and_go")
    except ValueError as refusal:
        message = str(refusal)
    assert swarm or message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < len(str(path)) + 300  # whatever was given is not repeated in full
