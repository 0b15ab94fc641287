"""Self-contained HTML page: title, lead, then verdict, numbers, tables and pictures in the given order."""

import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from q2q_model import palette

COLOURS = f":root {{ color-scheme: light; --good: {palette.GREEN}; --bad: {palette.VERMILLION}; }}"
CSS = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 1120px; }
body { margin: 1.5rem auto; padding: 0 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; }
.verdict { border-left: .3rem solid var(--good); padding: .2rem .8rem; background: #f4f5f7; }
.verdict.bad { border-color: var(--bad); font-weight: 600; }
.numbers { display: grid; gap: 1rem 1.5rem; margin: 1.2rem 0; max-width: 50rem; }
.numbers { grid-template-columns: repeat(auto-fit, minmax(9rem, 1fr)); }
.numbers b { display: block; font-size: 2.2rem; line-height: 1.15; }
.numbers div { border-top: .3rem solid #888; padding-top: .3rem; }
.scroll { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .3rem .7rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
th { background: #f4f5f7; font-weight: 600; white-space: pre-line; vertical-align: bottom; }
.text, .words { text-align: left; } td.words { white-space: pre-line; min-width: 12rem; }
td { vertical-align: top; }
.pictures { display: grid; gap: 1.2rem; margin: 1rem 0; }
.pictures { grid-template-columns: repeat(auto-fill, minmax(min(420px, 100%), 1fr)); }
@media (max-width: 600px) { th, td { padding: .25rem .4rem; } body { padding: 0 .8rem; } }
@media (max-width: 600px) { td.text { white-space: normal; } td.words { min-width: 10rem; } }
pre { overflow-x: auto; background: #f4f5f7; padding: .6rem .8rem; font-size: .88rem; }
code { white-space: nowrap; }
figure { margin: 0; } img { width: 100%; height: auto; } figcaption { color: #555; font-size: .9rem; }
"""

WORDS = 24
"""Cell length from which a column is wrapped."""
NUMBER = re.compile(r"[+-]?[\d.]+(?: · 10⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)?%?|-|")
"""Cell of a column that is right-aligned, where one has a digit."""
DIGIT = re.compile(r"\d")
CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True)
class Picture:
    """Picture file and its caption."""

    path: Path
    caption: str


@dataclass(frozen=True, slots=True)
class Grid:
    """Table of texts: head and rows."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    has_code: bool = False
    """Whether backticks enclose commands: in q2q's own texts, not where names of users stand."""


@dataclass(frozen=True, slots=True)
class Heading:
    """Heading of a section."""

    text: str


@dataclass(frozen=True, slots=True)
class TextWithCode:
    """Paragraph of q2q's own, with commands between backticks."""

    text: str


@dataclass(frozen=True, slots=True)
class PageVerdict:
    """Outcome of all that a page shows, in one line."""

    text: str
    ok: bool


@dataclass(frozen=True, slots=True)
class KeyNumber:
    """Number with its unit, shown large, and what it is."""

    value: str
    meaning: str
    colour: str = palette.GREY


@dataclass(frozen=True, slots=True)
class Markup:
    """HTML of our own, such as a flight replay, that is placed as it is."""

    html: str


@dataclass(frozen=True, slots=True)
class ProgramOutput:
    """Lines as a program printed them."""

    text: str


Part = (
    Grid
    | Heading
    | TextWithCode
    | PageVerdict
    | Markup
    | ProgramOutput
    | Sequence[Picture]
    | Sequence[KeyNumber]
    | str
)


def page(title: str, lead: str, parts: Sequence[Part]) -> str:
    """Return the page's HTML: title, one lead paragraph, then the parts in order."""
    body = "\n".join(_part(part) for part in parts)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{COLOURS}{CSS}</style></head>\n"
        f"<body><h1>{escape(title)}</h1><p>{escape(lead)}</p>\n{body}\n</body></html>\n"
    )


def _part(part: Part) -> str:
    match part:
        case str() | TextWithCode():
            return f"<p>{escape(part) if isinstance(part, str) else _with_code(part.text)}</p>"
        case Markup():
            return part.html
        case Heading() | ProgramOutput():
            tag = "h2" if isinstance(part, Heading) else "pre"
            return f"<{tag}>{escape(part.text)}</{tag}>"
        case PageVerdict():
            return f'<p class="verdict{"" if part.ok else " bad"}">{escape(part.text)}</p>'
        case Grid():
            return _table(part)
        case _:
            return _row_of(part)


def _row_of(parts: Sequence[Picture] | Sequence[KeyNumber]) -> str:
    """Return pictures or numbers side by side."""
    pictures = "".join(_figure(one) for one in parts if isinstance(one, Picture))
    numbers = "".join(_number(one) for one in parts if isinstance(one, KeyNumber))
    return f'<div class="{"pictures" if pictures else "numbers"}">{pictures}{numbers}</div>'


def _number(one: KeyNumber) -> str:
    value, meaning = escape(one.value), escape(one.meaning)
    return f'<div style="border-color: {one.colour}"><b>{value}</b>{meaning}</div>'


def _table(grid: Grid) -> str:
    columns = list(zip(*grid.rows, strict=True)) or [()] * len(grid.head)
    kinds = [_kind(column) for column in columns]
    words = _with_code if grid.has_code else escape
    lines = [_line("td", kinds, map(words, row)) for row in grid.rows]
    head = _line("th", kinds, map(words, grid.head))
    table = f"<table><thead>{head}</thead><tbody>{''.join(lines)}</tbody></table>"
    return f'<div class="scroll">{table}</div>'


def _kind(column: Sequence[str]) -> str:
    """Return the class of a column's cells: long text, text, or numbers."""
    if any(len(cell) >= WORDS for cell in column):
        return ' class="words"'
    is_number = any(map(DIGIT.search, column)) and all(map(NUMBER.fullmatch, column))
    return "" if is_number else ' class="text"'


def _line(tag: str, kinds: Sequence[str], cells: Iterable[str]) -> str:
    """Return the HTML of a row, in whose cells a long name may be wrapped at each underscore."""
    wrapped = zip(kinds, (cell.replace("_", "_<wbr>") for cell in cells), strict=True)
    return f"<tr>{''.join(f'<{tag}{kind}>{cell}</{tag}>' for kind, cell in wrapped)}</tr>"


def _with_code(text: str) -> str:
    """Return the HTML of a text with commands and names between backticks."""
    return CODE.sub(r"<code>\1</code>", escape(text))


def _figure(picture: Picture) -> str:
    data = b64encode(picture.path.read_bytes()).decode()
    caption = escape(picture.caption)
    image = f'<img src="data:image/png;base64,{data}" alt="{caption}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"
