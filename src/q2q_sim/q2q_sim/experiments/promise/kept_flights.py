"""Finished flights in a file of JSON lines, from which an interrupted series resumes."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from q2q_model.documents.plain_values import from_plain, to_plain
from q2q_sim.experiments.promise.room_encounter import EncounterRecord, PromiseCase
from q2q_sim.processes.resume_log import exclusive_log, read_entries


@dataclass(frozen=True, slots=True)
class KeptFlight:
    """A finished flight, and what was flown."""

    case: PromiseCase
    record: EncounterRecord


Fly = Callable[[Sequence[int]], Iterable[EncounterRecord]]
"""Flies seeds; yields their records as they end."""


def resume_flights(
    seeds: Sequence[int], case: PromiseCase, file: Path, fly: Fly
) -> Iterator[EncounterRecord]:
    """Yield the records of all seeds: those of the file, then the others, which are added to it as they end.

    Raises:
        ValueError: the file has other content, or flights of another case, or is in use.
    """
    with exclusive_log(file) as log:
        entries = read_entries(file, lambda document: from_plain(KeptFlight, document, ""))
        kept = {one.record.seed: one for one in entries}
        if any(one.case != case for one in kept.values()):
            raise ValueError(
                f"{file} holds flights with another tube, controller or air: name another --keep"
            )
        yield from (kept[seed].record for seed in seeds if seed in kept)
        for record in fly([seed for seed in seeds if seed not in kept]):
            log.write(json.dumps(to_plain(KeptFlight(case, record))) + "\n")
            log.flush()
            yield record
