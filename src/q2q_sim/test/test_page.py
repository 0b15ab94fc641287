"""The page carries its pictures and never lets text become markup."""

from base64 import b64decode
from pathlib import Path

from q2q_sim.report.html_page import Grid, Picture, page


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
