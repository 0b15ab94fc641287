"""Numbers of the paper, from one file with the place of each."""

from dataclasses import dataclass
from pathlib import Path

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.nearest_name import name_hint

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


@dataclass(frozen=True, slots=True)
class _Entry:
    """Number in the file, under its id."""

    paper: float | None
    unit: str
    where: str
    note: str

    def __post_init__(self) -> None:
        if not (self.unit and self.where and self.note):
            raise ValueError("must have unit, where and note")


def paper_numbers(file: Path = FILE) -> tuple[PaperNumber, ...]:
    """Return every number, in the order of the file.

    Raises:
        ValueError: an entry lacks its unit, place or note.
    """
    read: list[PaperNumber] = []
    for name, one in from_plain(dict[str, _Entry], load_yaml(file), str(file)).items():
        note = read[-1].note if one.note == SAME and read else one.note
        read.append(PaperNumber(name, one.paper, one.unit, one.where, note))
    return tuple(read)


def select_numbers(numbers: tuple[PaperNumber, ...], only: str) -> tuple[PaperNumber, ...]:
    """Return the numbers of the groups in `only` (table6,fig10); all if it is empty.

    Raises:
        ValueError: unknown table or figure; the message names the nearest.
    """
    known = tuple(dict.fromkeys(one.group for one in numbers))
    wanted = [word.strip() for word in only.split(",") if word.strip()]
    for word in wanted:
        if word not in known:
            raise ValueError(f"--only {word}: {name_hint(word, known)}")
    return tuple(one for one in numbers if not wanted or one.group in wanted)
