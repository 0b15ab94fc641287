"""Check of recorded flights against the safety policies."""

import json
import sys
import warnings
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from q2q_model.bag import BagReader, BagRepairWarning
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.tools.bag_vehicle import flown_vehicle
from q2q_sim.flight.run_json import Json, finite
from q2q_sim.loop.topics import TICK_TOPICS
from q2q_sim.monitors.policies import (
    POLICIES,
    Circumstances,
    Evidence,
    RecordedSignal,
    Violation,
    evidence_of,
    judge,
)
from q2q_sim.scenarios import library


def run(args: Namespace) -> int:
    """Check the named bags; return 1 if a policy is violated."""
    found = {
        str(bag): judge(evidence_in(bag), circumstances_of(bag, args.scenario, args.vehicle))
        for bag in args.bags
    }
    if args.json:
        print(json.dumps({bag: as_json(violations) for bag, violations in found.items()}, indent=1))
    else:
        for bag, violations in found.items():
            print("\n".join(f"{bag}: {one}" for one in violations) or f"{bag}: keeps {', '.join(POLICIES)}")
    return int(any(found.values()))


def circumstances_of(bag: Path, scenario: str, vehicle: str) -> Circumstances:
    """Return the circumstances of a flight; raise ValueError for an unknown name."""
    if scenario:
        flown = library.load(scenario)
        return Circumstances(vehicle=flown.vehicle, faults=flown.faults)
    flown_by = flown_vehicle(bag, vehicle)
    if flown_by.note:
        print(f"policies: {flown_by.note}", file=sys.stderr)
    return Circumstances(vehicle=flown_by.vehicle)


def evidence_in(bag: Path) -> Evidence:
    """Return the evidence in a bag, with a BagRepairWarning if messages may be missing.

    Raises:
        ValueError: the bag cannot be read or has no flight.
    """
    reader = BagReader(bag)
    for repair in reader.repairs:
        warnings.warn(repair, BagRepairWarning, stacklevel=2)
    known = {topic for topic in reader.topics if topic.lstrip("/") in TICK_TOPICS}
    return evidence_of(
        RecordedSignal(one.topic.lstrip("/"), time_from_stamp(one.stamp_ns), one.signal)
        for one in reader.signals(known)
    )


def as_json(violations: Sequence[Violation]) -> Json:
    """Return violations as plain values."""
    return [
        {key: finite(value) if isinstance(value, float) else value for key, value in asdict(one).items()}
        for one in violations
    ]
