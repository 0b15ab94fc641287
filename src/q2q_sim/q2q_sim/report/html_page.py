"""Self-contained HTML page with tables and pictures."""

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

CSS = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1120px; }
body { margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .2rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; }
table { display: block; overflow-x: auto; }
th, td { padding: .3rem .7rem; border-bottom: 1px solid #ddd; text-align: right; }
th { background: #f4f5f7; font-weight: 600; } td:first-child, th:first-child { text-align: left; }
td:nth-child(2), th:nth-child(2), .words { text-align: left !important; }
td:not(.words) { white-space: nowrap; }
.pictures { display: grid; gap: 1rem; }
.pictures { grid-template-columns: repeat(auto-fit, minmax(min(460px, 100%), 1fr)); }
@media (max-width: 600px) { th, td { padding: .2rem .25rem; font-size: 11px; line-height: 1.3; } }
figure { margin: 0; } img { width: 100%; } figcaption { color: #666; font-size: .9rem; }
"""

WORDS = 24
"""Cell length from which a column is text: left-aligned and wrapped."""


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


def page(title: str, lead: str, parts: Sequence[Grid | Sequence[Picture] | str]) -> str:
    """Return the page's HTML: title, one lead paragraph, then tables, picture grids and texts in order."""
    body = "\n".join(_part(part) for part in parts)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{CSS}</style></head>\n'
        f"<body><h1>{escape(title)}</h1><p>{escape(lead)}</p>\n{body}\n</body></html>\n"
    )


def _part(part: Grid | Sequence[Picture] | str) -> str:
    if isinstance(part, str):
        return f"<p>{escape(part)}</p>"
    if isinstance(part, Grid):
        return _table(part)
    return f'<div class="pictures">{"".join(_figure(picture) for picture in part)}</div>'


def _table(grid: Grid) -> str:
    long_text = [any(len(cell) >= WORDS for cell in column) for column in zip(*grid.rows, strict=True)]
    kinds = [' class="words"' if words else "" for words in long_text or [False] * len(grid.head)]
    lines = [_line("td", kinds, row) for row in grid.rows]
    head = _line("th", kinds, grid.head)
    return f"<table><thead>{head}</thead><tbody>{''.join(lines)}</tbody></table>"


def _line(tag: str, kinds: Sequence[str], cells: Sequence[str]) -> str:
    marked = zip(kinds, cells, strict=True)
    return f"<tr>{''.join(f'<{tag}{kind}>{escape(cell)}</{tag}>' for kind, cell in marked)}</tr>"


def _figure(picture: Picture) -> str:
    data = b64encode(picture.path.read_bytes()).decode()
    caption = escape(picture.caption)
    image = f'<img src="data:image/png;base64,{data}" alt="{caption}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"
