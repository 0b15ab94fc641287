"""Read the project's documents: links, headings, and code blocks and what the reader does with each.

A block is fenced, or indented by four spaces. What it is shows by its language, or by how it begins: with a
command, or with a YAML key. The paragraph before it says where it goes:

| words before a block | the reader |
|---|---|
| Write `FILE` | writes it into that file |
| Append to `FILE` | adds it to that file |
| Replace `NAME` in `FILE` | puts it in the place of the assignment to NAME |
| anything else | types the commands, or runs the Python |
"""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent

from fresh_checkout import ROOT

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```|(?<=\n\n)((?:    [^\n]*\n|\n(?=    ))+)", re.MULTILINE | re.DOTALL)
ACTION = re.compile(r"(Write|Append to|Replace `(\w+)` in) `([^`]+)`", re.IGNORECASE)
KEY = re.compile(r"[a-z_]+:(\s|$)")
STARTS = ("scripts/", "ros2 ", "source ", "python ", "export ", "fastdds ", "LD_LIBRARY_PATH=")
"""What a line that is a command begins with."""
MADE_BY_COMMANDS = ("out/",)
"""Where the documents' own commands leave files."""


@dataclass(frozen=True, slots=True)
class Block:
    """Code block of a document."""

    document: str
    line: int
    language: str
    """shell, yaml, json, python; empty for a drawing, or a language nobody runs."""
    text: str
    action: str = ""
    """write, append or replace; empty if the reader runs it."""
    file: str = ""
    """Where it goes."""
    name: str = ""
    """What it replaces there."""

    @property
    def where(self) -> str:
        """Return document and line."""
        return f"{self.document}:{self.line}"


@dataclass(frozen=True, slots=True)
class Command:
    """Command line of a document."""

    document: str
    text: str
    """As it is typed."""
    written: tuple[str, ...] = ()
    """Files that its document has the reader write."""

    @property
    def where(self) -> str:
        """Return document and command."""
        return f"{self.document}: {self.text}"

    @property
    def words(self) -> tuple[str, ...]:
        """Return the words, without a comment."""
        return tuple(shlex.split(self.text, comments=True))

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


def documents() -> list[Path]:
    """Return README.md, CONTRIBUTING.md and all of docs/, without what scripts/site makes there."""
    pages = sorted((ROOT / "docs").rglob("*.md"))
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(one for one in pages if one.parent.name != "api")]


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


def blocks(document: Path) -> list[Block]:
    """Return the code blocks of a document, in its order."""
    text = document.read_text(encoding="utf-8")
    made = []
    for found in BLOCK.finditer(text):
        body = found[2] if found[3] is None else dedent(found[3])
        before = text[: found.start()]
        actions = list(ACTION.finditer(before.rstrip().rpartition("\n\n")[2]))
        action, name, file = actions[-1].groups() if actions else ("", "", "")
        made.append(
            Block(
                document=str(document.relative_to(ROOT)),
                line=before.count("\n") + 1,
                language=found[1] or _language(body),
                text=body,
                action=action.split()[0].lower() if action else "",
                file=file,
                name=name or "",
            )
        )
    return made


def commands() -> list[Command]:
    """Return the command lines of all documents."""
    found = []
    for document in documents():
        all_of_it = blocks(document)
        written = tuple(block.file for block in all_of_it if block.action == "write")
        found += [
            Command(block.document, line, written)
            for block in all_of_it
            if block.language == "shell"
            for line in command_lines(block.text)
        ]
    return found


def snippets() -> list[Block]:
    """Return the YAML, JSON and Python of all documents."""
    every = [block for document in documents() for block in blocks(document)]
    return [block for block in every if block.language in {"yaml", "json", "python"}]


def command_lines(text: str) -> Iterator[str]:
    """Yield the command lines of a block, stripped; lines joined by a backslash are one."""
    kept = ""
    for line in text.splitlines():
        kept += line.strip()
        if kept.endswith("\\"):
            kept = kept[:-1]
            continue
        if kept:
            yield kept
        kept = ""


def _language(body: str) -> str:
    """Return the language of a block that names none."""
    first = body.strip()
    if first.startswith(STARTS):
        return "shell"
    return "yaml" if KEY.match(first) else ""
