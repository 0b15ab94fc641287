"""Findings of a flight in the lines of a table's cell, those of one reason together under it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from q2q_sim.licence.rules.broken_rule import BrokenRule

TIME = re.compile(r" at \d+\.\d+ s\b")
"""Time in a reason: links that a failing program closes one after the other share the rest of theirs."""


def finding_lines(findings: Sequence[BrokenRule]) -> Iterator[str]:
    """Yield a line for each finding; what several have as their reason is a line before theirs."""
    groups: dict[tuple[bool, str], list[BrokenRule]] = {}
    for one in findings:
        groups.setdefault((one.remark, TIME.sub("", one.why)), []).append(one)
    for (remark, why), found in groups.items():
        if len(found) == 1 or not why:
            yield from (one.sentence for one in found)
            continue
        reason = found[0].why if len({one.why for one in found}) == 1 else why
        yield f"{'remarks: ' if remark else ''}{reason}:"
        yield from (f"• {replace(one, why='', remark=False).sentence}" for one in found)
