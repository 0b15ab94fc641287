"""A YAML text becomes plain values, or one line says what is wrong and where."""

from pathlib import Path

import pytest

from q2q_model.documents.yaml_text import load_yaml, parse_yaml

NINE_TO_THE_NINTH = "- &a0 [x]\n" + "".join(
    f"- &a{i} [{','.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 10)
)


def test_a_text_becomes_plain_values_with_anchors_and_merges() -> None:
    text = "base: &b {x: 1, y: [a, null]}\nmade: {<<: *b, x: 2.5}\n"
    assert parse_yaml(text) == {"base": {"x": 1, "y": ["a", None]}, "made": {"x": 2.5, "y": ["a", None]}}
    assert parse_yaml("") is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\nb: [", "is not valid YAML: line 2: expected the node content, but found '<stream end>'"),
        ("a: 1\nb: {c: 1, c: 2}", "is not valid YAML: line 2: duplicate key 'c': give each key once"),
        ("a: 1\na: 2", "is not valid YAML: line 2: duplicate key 'a': give each key once"),
        ("!!python/object:os.system {}", "is not valid YAML: line 1: could not determine a constructor"),
        ("a: !!bool x", "is not valid YAML: 'x'"),
        ("a: !!int x", "is not valid YAML: invalid literal for int()"),
        ("a: !!timestamp x", "is not valid YAML: "),
        ("a: 2024-13-45", "is not valid YAML: month must be in 1..12"),
        ("? {a: 1}\n: 2", "is not valid YAML: line 1: found unhashable key"),
        ("a: \x00", "is not valid YAML: "),
        ("[" * 5000, "is nested too deeply"),
        (
            NINE_TO_THE_NINTH,
            "is not valid YAML: line 1: more than 1000000 values: write fewer values or aliases",
        ),
        ("a: &a [*a]", "is not valid YAML: line 1: more than 1000000 values"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, said: str) -> None:
    with pytest.raises(ValueError, match="is ") as refusal:
        parse_yaml(text)
    assert str(refusal.value).startswith(said)
    assert "\n" not in str(refusal.value)


def test_the_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    with pytest.raises(ValueError, match=r"mine\.yaml: cannot be read \(No such file or directory\)"):
        load_yaml(path)
    path.write_bytes(b"\xff\xfe\x00\x00\xff")
    with pytest.raises(ValueError, match=r"mine\.yaml: cannot be read \(not UTF-8"):
        load_yaml(path)
    path.write_text("a: [")
    with pytest.raises(ValueError, match=r"mine\.yaml: is not valid YAML: line 1"):
        load_yaml(path)


@pytest.mark.parametrize(("text", "value"), [
    ("1e-3", 1e-3), ("-2E+6", -2e6), ("1.e3", 1e3), ("1.0e-3", 1e-3), ("3", 3),
    ("e3", "e3"), ("1e", "1e"), ("1e3x", "1e3x"), ("0x1f", 31), ("-0", 0), ("+2", 2),
    (".5", 0.5), ("-1.", -1.0), ("08.5", 8.5), ("-.inf", float("-inf")),
    ("010", "010"), ("1:30", "1:30"), ("1:30.5", "1:30.5"), ("1_0", "1_0"),
    ("0o10", "0o10"), ("-0x1f", "-0x1f"), ("0x1F", 31), ("on", True),  # the last as in YAML 1.1
])  # fmt: skip
def test_numbers_are_those_on_which_yaml_1_1_and_1_2_agree_and_those_of_json(
    text: str, value: object
) -> None:
    assert parse_yaml(f"a: {text}") == {"a": value}
