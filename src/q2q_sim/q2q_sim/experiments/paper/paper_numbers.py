"""Numbers of the paper, from one file with the place of each."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

import yaml

SAME = "as above"
"""Note that repeats the one before it."""
FILE = Path(__file__).with_name("paper.yaml")


@dataclass(frozen=True, slots=True)
class PaperNumber:
    """One number of the paper."""

    id: str
    paper: float | None
    """None if the paper has a curve or text."""
    unit: str
    where: str
    note: str
    """Reason for a different or missing value of ours."""

    @property
    def group(self) -> str:
        """Return its table or figure: table6, fig10."""
        return self.id.partition(".")[0]


def paper_numbers(file: Path = FILE) -> tuple[PaperNumber, ...]:
    """Return every number, in the order of the file.

    Raises:
        ValueError: an entry lacks its unit, place or note.
    """
    document = yaml.safe_load(file.read_text(encoding="utf-8"))
    read = [_number(name, entry) for name, entry in document.items()]
    for k, one in enumerate(read):
        if one.note == SAME and k > 0:
            read[k] = replace(one, note=read[k - 1].note)
    return tuple(read)


def chosen(numbers: tuple[PaperNumber, ...], only: str) -> tuple[PaperNumber, ...]:
    """Return the numbers of the groups in `only` (table6,fig10); all if it is empty.

    Raises:
        ValueError: unknown table or figure; the message names the nearest.
    """
    known = tuple(dict.fromkeys(one.group for one in numbers))
    wanted = [word.strip() for word in only.split(",") if word.strip()]
    for word in wanted:
        if word not in known:
            near = get_close_matches(word, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            raise ValueError(f"--only {word}: {hint}")
    return tuple(one for one in numbers if not wanted or one.group in wanted)


def _number(name: str, entry: Mapping[str, str | float | None]) -> PaperNumber:
    paper = entry.get("paper")
    words = [str(entry.get(key) or "") for key in ("unit", "where", "note")]
    if not all(words) or isinstance(paper, str) or entry.keys() != {"paper", "unit", "where", "note"}:
        raise ValueError(f"{name}: {dict(entry)}: paper (number or null), unit, where and note are expected")
    return PaperNumber(name, paper, *words)
