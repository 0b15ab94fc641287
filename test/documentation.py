"""Read the project's documents: their links, and the command lines in their code blocks."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fresh_checkout import ROOT

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
STARTS = ("scripts/", "ros2 ", "source ")
"""What a line that is a command begins with."""
MADE_BY_COMMANDS = ("out/",)
"""Where the documents' own commands leave files."""


@dataclass(frozen=True, slots=True)
class Command:
    """Hold one command line of a document."""

    where: str
    words: tuple[str, ...]

    @property
    def program(self) -> tuple[str, ...]:
        """Return the words that name the program."""
        return self.words[:4] if self.words[:2] == ("ros2", "run") else self.words[:1]

    @property
    def options(self) -> tuple[str, ...]:
        """Return the options, without their values and without what goes to ROS itself."""
        ours = self.words[: self.words.index("--ros-args")] if "--ros-args" in self.words else self.words
        return tuple(word.partition("=")[0] for word in ours if re.fullmatch(r"--?[a-z][a-z-]*(=.*)?", word))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Return the ROS parameters it sets."""
        pairs = zip(self.words, self.words[1:], strict=False)
        return tuple(word.partition(":=")[0] for before, word in pairs if before == "-p")

    @property
    def files(self) -> tuple[str, ...]:
        """Return the words that name files of the checkout."""
        values = [word.partition(":=")[2] or word for word in self.words[1:]]
        paths = [word for word in values if re.fullmatch(r"[a-z][\w.-]*(/[\w.-]+)+", word)]
        return tuple(word for word in paths if not word.startswith(MADE_BY_COMMANDS))


def documents() -> list[Path]:
    """Return README.md and all of docs/."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def links(document: Path) -> list[str]:
    """Return the relative links of a document, without what comes after #."""
    found = LINK.findall(document.read_text(encoding="utf-8"))
    return [link.partition("#")[0] for link in found if "://" not in link and not link.startswith("#")]


def commands() -> list[Command]:
    """Return the command lines of all documents."""
    return [
        Command(f"{document.relative_to(ROOT)}: {line}", tuple(shlex.split(line, comments=True)))
        for document in documents()
        for line in code_lines(document.read_text(encoding="utf-8"))
        if line.startswith(STARTS)
    ]


def code_lines(text: str) -> Iterator[str]:
    """Yield the lines of indented and fenced code blocks, stripped; lines joined by a backslash are one."""
    fenced, kept = False, ""
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            kept += line.strip()
            if kept.endswith("\\"):
                kept = kept[:-1]
                continue
            yield kept
        kept = ""
