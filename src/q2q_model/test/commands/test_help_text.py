"""Help fits the terminal, keeps examples and tables as written, and gives defaults."""

import pytest

from q2q_model.commands.command_line import CommandLine

ABOUT = f"""Does things.

| a | table that is wider than a terminal of eighty columns, and is kept as it is written |
|---|---|

{"Prose of --many-words. " * 9}"""
EXAMPLE = f"  tool {'--seed 3 ' * 12}"


def help_at(columns: int, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("COLUMNS", str(columns))
    line = CommandLine("tool", ABOUT, EXAMPLE)
    line.add_argument("--seed", default=0, help="seed")
    line.add_argument("--airs", nargs="+", default=("room", "bent"), help="airs")
    line.add_argument("--share", default="5 %", help="30 %% or less")
    line.add_argument("--runs", default=7, help="runs (default: seven)")
    line.add_argument("--json", help="file")
    line.add_argument("--live", action="store_true", help="wall time")
    return line.format_help()


@pytest.mark.parametrize("columns", [60, 80])
def test_prose_is_filled_to_the_terminal_and_no_option_in_it_is_split(
    columns: int, monkeypatch: pytest.MonkeyPatch
):
    text = help_at(columns, monkeypatch)
    prose = text[text.index("Prose") : text.index("options:")].split("\n")
    assert max(map(len, prose)) <= columns - 2
    assert all(len(line) > columns - 2 - len("--many-words. ") for line in prose[:2])
    assert " ".join(prose).count("--many-words") == 9


def test_an_example_and_a_table_are_kept_as_written(monkeypatch: pytest.MonkeyPatch):
    lines = help_at(80, monkeypatch).splitlines()
    assert EXAMPLE.rstrip() in [line.rstrip() for line in lines]
    assert "|---|---|" in lines


def test_a_default_is_reported_once_and_only_where_there_is_one(monkeypatch: pytest.MonkeyPatch):
    text = " ".join(help_at(80, monkeypatch).split())
    for message in (
        "--seed SEED seed (default 0)",
        "airs (default room bent)",
        "30 % or less (default 5 %)",
        "runs (default: seven) --json JSON file --live wall time example:",
    ):
        assert message in text
