"""Pages in docs/nodes: topics, types, qualities of service, services and parameters of each node.

The text is the docstring of the node's module, the rest is what the node declares. `--images` draws the
pictures of the documentation.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.documents.written_file import write_text
from q2q_sim.report.markdown_table import markdown_table
from q2q_sim.ros.node_survey import NodeInterface, SurveyedParameter, survey
from q2q_sim.ros.stand_in import RecordedPort
from q2q_sim.tools.docs.animation import write_animation
from q2q_sim.tools.docs.images import OUT, write_images

MADE = "<!-- Made by scripts/node_pages from the nodes themselves; change those, then run it again. -->"


def run(args: Namespace) -> int:
    """Write or check the pages; return the exit status."""
    current = pages(survey())
    stale = out_of_date(current, args.out)
    if args.check:
        for name in stale:
            print(f"node_pages: {args.out / name} is out of date: run scripts/node_pages", file=sys.stderr)
        return 1 if stale else 0
    write(current, args.out)
    print(f"node_pages: {len(current)} pages in {args.out}, {len(stale)} new or changed")
    if args.images:
        print(*(f"node_pages: {path}" for path in [*write_images(), write_animation(OUT)]), sep="\n")
    return 0


def pages(nodes: Sequence[NodeInterface]) -> dict[str, str]:
    """Return the text of every page by its file name; `README.md` lists them."""
    return {f"{node.executable}.md": node_page(node) for node in nodes} | {"README.md": index(nodes)}


def out_of_date(current: dict[str, str], folder: Path) -> list[str]:
    """Return the pages in `folder` that are missing, differ from `current`, or belong to no node."""
    there = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.md")}
    return sorted(name for name in {*current, *there} if current.get(name) != there.get(name))


def write(current: dict[str, str], folder: Path) -> None:
    """Write every page and delete pages of removed nodes."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.glob("*.md"):
        if path.name not in current:
            path.unlink()
    for name, text in current.items():
        write_text(text, folder / name)


def index(nodes: Sequence[NodeInterface]) -> str:
    """Return the list of the nodes."""
    rows = [
        (
            f"[`{node.executable}`]({node.executable}.md)",
            f"`{node.package}`",
            node.description.splitlines()[0],
        )
        for node in nodes
    ]
    return f"{MADE}\n# Nodes\n\n{table(('node', 'package', 'what it does'), rows)}"


def node_page(node: NodeInterface) -> str:
    """Return a node's page."""
    command = f"    ros2 run {node.package} {node.executable}"
    topics = [_port_row(port, when) for port, when in node.ports if port.direction != "serves"]
    services = [_port_row(port, when)[1:] for port, when in node.ports if port.direction == "serves"]
    parameters = [_parameter_row(one) for one in node.parameters]
    return "\n".join(
        [
            f"{MADE}\n# {node.executable}\n\n{node.description}\n\n{command}\n\n## Topics\n",
            table(("", "topic", "type", "quality of service", "only with"), topics),
            "## Services\n",
            table(("service", "type", "", "only with"), services),
            "## Parameters\n",
            table(("parameter", "default", "allowed", "in flight", "only with", "meaning"), parameters)
            if parameters
            else "None.\n",
        ]
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table without columns that are empty in every row."""
    kept = [column for column in range(len(head)) if any(row[column] for row in rows)]
    named, *shown = [[cells[column] for column in kept] for cells in (head, *rows)]
    return markdown_table(named, shown, len(kept)) + "\n"


def _port_row(port: RecordedPort, when: str) -> tuple[str, ...]:
    return port.direction, f"`{port.name}`", f"`{port.kind}`", port.quality, when


def _parameter_row(one: SurveyedParameter) -> tuple[str, ...]:
    given = one.declared
    changes = "may change" if one.settable and not given.read_only else "fixed"
    return (
        f"`{given.name}`",
        f"`{_default(given.default)}`",
        given.allowed,
        changes,
        one.requires,
        given.description,
    )


def _default(default: object) -> str:
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, str):
        return f'"{default}"'
    return str(default) if isinstance(default, int | float | list) else "[]"
