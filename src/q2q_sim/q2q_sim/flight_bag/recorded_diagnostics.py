"""Summary of a bag's `/diagnostics`: worst level, last message and last values of each node.

Recorded by `bag_record` with
`-p extra:="['diagnostics:diagnostic_msgs/msg/DiagnosticArray']"`.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from q2q_model.bag import BagReader, RawMessage
from q2q_model.bag.storage.definitions import jazzy_types, naming_message
from q2q_model.diagnostics.health import Level

TOPIC = "/diagnostics"
TYPE = "diagnostic_msgs/msg/DiagnosticArray"


class _Value(Protocol):
    key: str
    value: str


class _Status(Protocol):
    name: str
    level: int
    values: list[_Value]


class _Array(Protocol):
    """Decoded diagnostic_msgs/DiagnosticArray."""

    status: list[_Status]


@dataclass(frozen=True, slots=True)
class NodeLife:
    """Health of a node over a recording."""

    node: str
    seconds: int
    """Number of its reports."""
    warned: int
    """Number of reports with level WARN or ERROR."""
    worst: Level
    """The worst of OK, WARN and ERROR; STALE if it never ticked."""
    values: str
    """Its last values that are not empty, as `name value, ...`."""


def recorded_lives(bag: Path) -> tuple[NodeLife, ...]:
    """Return a row for each node with reports, sorted by name; none if nothing was recorded.

    Raises BagError for a message that is no DiagnosticArray.
    """
    reader = BagReader(bag)
    if TOPIC not in reader.topics:
        return ()
    reports: dict[str, list[tuple[Level, str]]] = {}
    for raw in reader.raw({TOPIC}):
        for status in _decoded(bag, raw).status:
            words = ", ".join(f"{one.key} {one.value}" for one in status.values if one.value)
            reports.setdefault(status.name, []).append((Level(status.level), words))
    return tuple(_life(name, reports[name]) for name in sorted(reports))


def _decoded(bag: Path, raw: RawMessage) -> _Array:
    with naming_message(bag, raw, TYPE):
        message: _Array = jazzy_types().deserialize_cdr(raw.data, TYPE)
    return message


def _life(node: str, reports: list[tuple[Level, str]]) -> NodeLife:
    levels = [level for level, _ in reports]
    reported = [level for level in levels if level != Level.STALE]
    warned = sum(level in (Level.WARN, Level.ERROR) for level in levels)
    return NodeLife(node, len(reports), warned, max(reported, default=Level.STALE), reports[-1][1])
