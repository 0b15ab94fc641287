"""Read the project's documents: links, headings, command lines and snippets in their code blocks."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fresh_checkout import ROOT

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
WRITE = re.compile(r"[Ww]rite `([^`]+)`")
STARTS = ("scripts/", "ros2 ", "source ", "python ", "export ")
"""What a line that is a command begins with."""
MADE_BY_COMMANDS = ("out/",)
"""Where the documents' own commands leave files."""


@dataclass(frozen=True, slots=True)
class Command:
    """Hold one command line of a document."""

    where: str
    words: tuple[str, ...]
    written: tuple[str, ...] = ()
    """Files its document tells to write."""

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
    def parameters(self) -> dict[str, str]:
        """Return the ROS parameters it sets, with their values as they are written."""
        pairs = zip(self.words, self.words[1:], strict=False)
        split = [word.partition(":=") for before, word in pairs if before == "-p"]
        return {name: value for name, _, value in split}

    @property
    def files(self) -> tuple[str, ...]:
        """Return the words that name files which must be in the checkout."""
        values = [word.partition(":=")[2] or word for word in self.words[1:]]
        paths = [word for word in values if re.fullmatch(r"[a-z][\w.-]*(/[\w.-]+)+", word)]
        return tuple(word for word in paths if not word.startswith((*MADE_BY_COMMANDS, *self.written)))


@dataclass(frozen=True, slots=True)
class Snippet:
    """Hold a fenced block of a language, or an indented one that begins as YAML does."""

    where: str
    language: str
    text: str
    file: str
    """Where the words before it tell to write it; empty where nowhere."""


def documents() -> list[Path]:
    """Return README.md and all of docs/."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def links(document: Path) -> list[str]:
    """Return the links of a document that lead to files or headings of the checkout."""
    return [link for link in LINK.findall(document.read_text(encoding="utf-8")) if "://" not in link]


def is_dead(document: Path, link: str) -> bool:
    """Return whether a link leads to no file, or to no heading of it."""
    name, _, anchor = link.partition("#")
    target = document.parent / name if name else document
    return not target.exists() or bool(anchor and anchor not in anchors(target))


def anchors(document: Path) -> set[str]:
    """Return the names of a document's headings, as they are shown on the web."""
    headings = HEADING.findall(document.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def commands() -> list[Command]:
    """Return the command lines of all documents."""
    found = []
    for document in documents():
        text = document.read_text(encoding="utf-8")
        written = tuple(WRITE.findall(text))
        found += [
            Command(f"{document.relative_to(ROOT)}: {line}", tuple(shlex.split(line, comments=True)), written)
            for line in code_lines(text)
            if line.startswith(STARTS)
        ]
    return found


def snippets() -> list[Snippet]:
    """Return the YAML, JSON and Python of all documents."""
    found = []
    for document in documents():
        text = document.read_text(encoding="utf-8")
        fenced = re.finditer(r"^```(\w+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
        plain = re.sub(r"^```.*?^```", _blank, text, flags=re.MULTILINE | re.DOTALL)
        indented = re.finditer(r"(?<=\n\n)()((?:    [^\n]*\n|\n(?=    ))+)", plain)
        for match in [*fenced, *(one for one in indented if re.match(r"    [a-z_]+:(\s|$)", one[2]))]:
            told = WRITE.findall(text[: match.start()].rstrip().rpartition("\n\n")[2])
            name = f"{document.relative_to(ROOT)}:{text[: match.start()].count(chr(10)) + 1}"
            found.append(Snippet(name, match[1] or "yaml", match[2], told[-1] if told else ""))
    return [one for one in found if one.language in {"yaml", "json", "python"}]


def _blank(block: re.Match[str]) -> str:
    """Return as many characters and lines as the block has, all empty."""
    return re.sub(r"[^\n]", ".", block[0])


def code_lines(text: str) -> Iterator[str]:
    """Yield the lines of indented and fenced code blocks, stripped; lines joined by a backslash are one.

    Blocks of a named language hold no commands.
    """
    fenced, kept = "", ""
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = "" if fenced else line.removeprefix("```") or "shell"
        elif fenced == "shell" or (not fenced and line.startswith("    ")):
            kept += line.strip()
            if kept.endswith("\\"):
                kept = kept[:-1]
                continue
            yield kept
        kept = ""
