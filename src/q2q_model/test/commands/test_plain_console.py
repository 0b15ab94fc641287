"""A plain console prints texts with rich's markup and emoji names as they are."""

import pytest
from rich.table import Table

from q2q_model.plain_console import plain_console

TEXTS = (
    "bad value in [/tmp/file]",
    "acc [nan nan nan] is not finite",
    "pl[red].json",
    ":warning: and [bold]",
)


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_printed_as_it_is(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    plain_console(width=80).print(text)
    assert capsys.readouterr().out == f"{text}\n"


@pytest.mark.parametrize("text", TEXTS)
def test_a_table_shows_texts_as_they_are(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    table = Table(text, title=text)
    table.add_row(text)
    plain_console(width=80).print(table)
    assert capsys.readouterr().out.count(text) == 3


def test_a_notice_goes_to_standard_error_if_asked(capsys: pytest.CaptureFixture[str]) -> None:
    plain_console(stderr=True).print("notice")
    assert capsys.readouterr() == ("", "notice\n")
