"""Plain values become the dataclass they describe, or every mistake is named, with what is expected."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np
import pytest

from q2q_model.documents.plain_values import PlainValueError, from_plain, to_plain
from q2q_model.documents.yaml_text import parse_yaml
from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class Point:
    """Part of a document."""

    pos: Annotated[tuple[float, float, float], "[x, y, z] in metres"]
    t: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a time before the start."""
        if self.t < 0.0:
            raise ValueError(f"t = {self.t}; must be at least 0 s")


@dataclass(frozen=True, slots=True)
class Document:
    """Every type that a document may have."""

    paths: Mapping[str, tuple[Point, ...]]
    count: int = 1
    on: bool = True
    reading: Literal["free", "fixed"] = "free"
    limit: float | None = None
    table: Array | None = None
    names: tuple[str, ...] = ()
    rest: Mapping[str, object] = field(default_factory=dict)


PATHS = {"cf1": [{"pos": [0, 1, 2]}]}


def test_a_document_becomes_the_values_it_gives_in_their_types() -> None:
    given = {
        "paths": {1: [{"pos": [0, 1, 2.5], "t": 3}], "cf2": []},
        "count": 3,
        "on": False,
        "reading": "fixed",
        "limit": 2,
        "table": [[1, 2], [3, 4]],
        "names": ["a", "b"],
        "rest": {"any": [1, "x"]},
    }
    read = from_plain(Document, given, "file")
    assert read.paths == {"1": (Point((0.0, 1.0, 2.5), 3.0),), "cf2": ()}
    assert (read.count, read.on, read.reading, read.limit) == (3, False, "fixed", 2.0)
    assert [type(value) for value in (*read.paths["1"][0].pos, read.limit)] == [float] * 4
    np.testing.assert_array_equal(read.table, [[1.0, 2.0], [3.0, 4.0]])
    assert (read.names, read.rest) == (("a", "b"), {"any": [1, "x"]})
    assert from_plain(Document, {"paths": {}, "limit": None}, "file") == Document({})


@pytest.mark.parametrize("name", ["on", "no", "null", "~"])
def test_a_name_that_yaml_reads_as_another_value_is_refused_and_in_quotes_taken(name: str) -> None:
    expected = r"paths.*; must be a name \(quote on, off, yes, no and null\)$"
    with pytest.raises(ValueError, match=expected):
        from_plain(Document, parse_yaml(f"paths: {{{name}: []}}"), "file")
    assert from_plain(Document, parse_yaml(f"paths: {{'{name}': []}}"), "file").paths == {name: ()}


def test_scalars_and_arrays_of_numpy_are_numbers_and_lists_of_python() -> None:
    given = {
        "paths": {"cf1": [{"pos": np.array([0, 1, 2.5]), "t": np.int64(3)}]},
        "count": np.int64(3),
        "on": np.bool_(False),  # noqa: FBT003  a value of a document
        "reading": np.str_("fixed"),
        "limit": np.float32(0.25),
        "table": np.array([[1, 2], [3, 4]]),
        "names": np.array(["a", "b"]),
    }
    plain = {
        "paths": {"cf1": [{"pos": [0, 1, 2.5], "t": 3}]},
        "count": 3,
        "on": False,
        "reading": "fixed",
        "limit": 0.25,
        "table": [[1, 2], [3, 4]],
        "names": ["a", "b"],
    }
    read, expected = (from_plain(Document, one, "file") for one in (given, plain))
    np.testing.assert_array_equal(read.table, expected.table)
    assert replace(read, table=None) == replace(expected, table=None)
    assert [type(one) for one in (read.count, read.on, read.limit)] == [int, bool, float]
    assert [type(one) for one in (*read.paths["cf1"][0].pos, *read.names)] == [float] * 3 + [str] * 2


def test_values_of_numpy_are_written_as_those_of_python() -> None:
    written = to_plain(Document({}, count=np.int64(3), on=np.True_, limit=np.float32(0.25)))
    assert json.loads(json.dumps(written)) == to_plain(Document({}, count=3, on=True, limit=0.25))
    with pytest.raises(PlainValueError, match="limit = nan: only finite numbers"):
        to_plain(Document({}, limit=np.float32(np.nan)))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"paths": PATHS, "count": np.float64(3.5)}, "count = 3.5; must be an integer"),
        ({"paths": PATHS, "limit": np.float32(np.nan)}, "limit = nan; must be a finite number"),
        ({"paths": {"cf1": [{"pos": np.zeros(2)}]}}, "paths.cf1[0].pos = [0.0, 0.0]; must be [x, y, z] in"),
        (None, "got None, expected a mapping with paths, count, on, reading, limit, table, names, "),
        ({}, "paths is missing"),
        ({"paths": PATHS, "cuont": 2}, "unknown key 'cuont'; did you mean count?"),
        ({"paths": PATHS, "x": 2}, "unknown key 'x'; choose one of paths, count, on, "),
        ({"paths": PATHS, "count": True}, "count = True; must be an integer"),
        ({"paths": PATHS, "count": "3"}, "count = '3'; must be an integer"),
        ({"paths": PATHS, "on": 1}, "on = 1; must be true or false"),
        ({"paths": PATHS, "limit": "3"}, "limit = '3'; must be a number"),
        ({"paths": PATHS, "limit": False}, "limit = False; must be a number"),
        ({"paths": PATHS, "limit": float("inf")}, "limit = inf; must be a finite number"),
        (
            {"paths": PATHS, "limit": 10**400},
            f"limit = 1{13 * '0'}...{15 * '0'}; must be a finite number",
        ),
        ({"paths": PATHS, "reading": "fast"}, "reading = 'fast'; must be one of free, fixed"),
        ({"paths": PATHS, "reading": []}, "reading = []; must be one of free, fixed"),
        ({"paths": PATHS, "names": "ab"}, "names = 'ab'; must be a list"),
        ({"paths": PATHS, "names": ["a", None]}, "names[1] = None; must be text"),
        (
            {"paths": PATHS, "table": [[1, 2], [3]]},
            "table = [[1, 2], [3]]; must be a list of rows of one length",
        ),
        ({"paths": PATHS, "table": [[1, "x"]]}, "table[0][1] = 'x'; must be a number"),
        ({"paths": []}, "paths = []; must be a mapping of names to values"),
        ({"paths": {"cf1": [{"pos": [1, 2]}]}}, "paths.cf1[0].pos = [1, 2]; must be [x, y, z] in metres"),
        ({"paths": {"cf1": [{"pos": [1, None, 2]}]}}, "paths.cf1[0].pos[1] = None; must be a number"),
        ({"paths": {"cf1": [{"pos": [1, 2, 3], "t": -1}]}}, "paths.cf1[0]: t = -1.0; must be at least 0 s"),
        (
            {"paths": {"cf1": [{"pos": [1, 2, 3], "z": 1}]}},
            "paths.cf1[0]: unknown key 'z'; choose one of pos, t",
        ),
    ],
)
def test_a_mistake_is_named_by_key_value_and_what_is_expected(given: object, said: str) -> None:
    with pytest.raises(PlainValueError) as refusal:
        from_plain(Document, given, "file")
    assert str(refusal.value).startswith(f"file: {said}")
    assert len(str(refusal.value)) < 120


def test_mistakes_are_named_at_once_and_the_fourth_is_counted() -> None:
    given = {"paths": {"cf1": [{"pos": "x"}, {}], "cf2": 7}, "count": 0.5, "nams": 1}
    with pytest.raises(PlainValueError) as refusal:
        from_plain(Document, given, "file")
    assert str(refusal.value) == (
        "file: paths.cf1[0].pos = 'x'; must be [x, y, z] in metres; paths.cf1[1].pos is missing; "
        "paths.cf2 = 7; must be a list; and 2 more"
    )


def test_a_field_with_an_underscore_has_the_key_that_python_reserves() -> None:
    @dataclass(frozen=True, slots=True)
    class Source:
        from_: str

    assert from_plain(Source, {"from": "x"}, "") == Source("x")
    for given, said in (({}, "from is missing"), ({"form": 1, "from": "x"}, "did you mean from")):
        with pytest.raises(PlainValueError, match=said):
            from_plain(Source, given, "file")


@pytest.mark.parametrize("depth", [100, 200, 900])
def test_an_array_that_is_nested_too_deeply_is_refused(depth: int) -> None:
    nested = json.loads("[" * depth + "1" + "]" * depth)
    with pytest.raises(PlainValueError, match=r"^file: "):
        from_plain(Document, {"paths": PATHS, "table": nested}, "file")


def test_unknown_keys_of_a_foreign_document_are_ignored_at_every_level() -> None:
    given = {"paths": {"cf1": [{"pos": [0, 1, 2], "color": "red"}]}, "version": 3}
    assert from_plain(Document, given, "", extra=True) == from_plain(Document, {"paths": PATHS}, "")


@pytest.mark.parametrize("error", [TypeError("broken"), KeyError("broken")])
def test_an_error_of_the_code_is_not_taken_for_a_mistake_of_the_document(error: Exception) -> None:
    @dataclass(frozen=True, slots=True)
    class Broken:
        x: float

        def __post_init__(self) -> None:
            raise error

    with pytest.raises(type(error), match="broken"):
        from_plain(Broken, {"x": 1.0}, "file")
