"""The page carries its pictures and never lets text become markup."""

from base64 import b64decode
from pathlib import Path

from q2q_sim.report.html_page import (
    Grid,
    KeyNumber,
    Markup,
    PageVerdict,
    Picture,
    ProgramOutput,
    TextWithCode,
    page,
)


def test_a_picture_travels_inside_the_page(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_bytes(b"\x89PNG picture")
    html = page("title", "lead", [[Picture(path, "caption")]])
    data = html.split("base64,")[1].split('"')[0]
    assert b64decode(data) == b"\x89PNG picture"


def test_text_is_escaped() -> None:
    html = page("<b>", "a & b", [Grid(["<i>"], [["<u>"]]), "<h>"])
    assert "<b>" not in html
    assert "<i>" not in html
    assert "&lt;u&gt;" in html
    assert "a &amp; b" in html


def test_columns_of_numbers_are_right_aligned_and_long_text_is_wrapped() -> None:
    rows = [["cf1", "0.13", "-"], ["cf2", "-7", "a text of more than twenty-four letters"]]
    html = page("t", "l", [Grid(["name", "value", "note"], rows)])
    assert '<td class="text">cf1</td><td>0.13</td><td class="words">-</td>' in html


def test_commands_are_not_split_and_long_names_in_tables_may_be() -> None:
    text = "run `fly <x> --real`."
    html = page("t", "l", [TextWithCode(text), Grid(["name", "n"], [["z_rmse_m", "1"]])])
    assert "<p>run <code>fly &lt;x&gt; --real</code>.</p>" in html
    assert "code { white-space: nowrap; }" in html
    assert '<td class="text">z_<wbr>rmse_<wbr>m</td>' in html


def test_names_keep_their_backticks() -> None:
    """Those of vehicles, flights and bags may have them; q2q's own tables say that theirs mean code."""
    html = page("t", "l", ["a `c`", Grid(["`c`"], [["`c`"]])])
    assert html.count("`c`") == 3
    assert '<td class="text"><code>c</code></td>' in page("t", "l", [Grid(["n"], [["`c`"]], has_code=True)])


def test_what_a_program_printed_keeps_its_lines() -> None:
    assert "<pre>a\n  b &lt;c&gt;</pre>" in page("t", "l", [ProgramOutput("a\n  b <c>")])


def test_a_column_in_which_no_cell_has_a_digit_is_text() -> None:
    html = page("t", "l", [Grid(["flight", "why"], [["a", "-"], ["b", "-"]])])
    assert html.count('<td class="text">-</td>') == 2


def test_a_verdict_that_is_bad_looks_different() -> None:
    assert 'class="verdict"' in page("t", "l", [PageVerdict("ok", ok=True)])
    assert 'class="verdict bad"' in page("t", "l", [PageVerdict("fell", ok=False)])


def test_large_numbers_and_our_own_markup_stand_in_their_order() -> None:
    html = page("t", "l", [Markup("<canvas></canvas>"), [KeyNumber("34 cm", "down"), KeyNumber("<1", "up")]])
    assert html.index("<canvas>") < html.index("34 cm") < html.index("&lt;1")
