"""Comparison of a refactoring with recorded flights, bit for bit.

    python test/flight_digests.py record FILE     # before: fly, and keep a digest of each flight
    python test/flight_digests.py compare FILE    # after: fly again; ends with 1 where a digest differs

Flights are those of `closed_loop`: shipped scenarios with every controller, mode and replanner, and random
faults through random scenarios as `scripts/campaign` draws them. A digest is of one machine and one set of
dependencies, so none is committed.
"""

import argparse
import hashlib
import json
import sys
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from q2q_model.model_files.find_model import find_model
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode
from q2q_sim.scenarios import library

SCENARIOS = (
    "section4_1",
    "table2_2",
    "table2_6",
    "table6",
    "table6_measured",
    "table6_room",
    "stack3",
    "crossing",
    "swarm6",
)
WAYS: tuple[tuple[Mode, str, str], ...] = (
    ("ignoring", "pid", "none"),
    ("aware", "pid", "safe"),
    ("aware_unlimited", "pid", "paper"),
    ("aware", "mpc", "none"),
    ("aware", "mpc", "safe"),
)
"""Mode, controller and replanner."""
LONGEST_S = 12.0
"""Flights are cut here [s]: every encounter of the shipped scenarios has begun by then."""
CAMPAIGN_SEEDS = range(40)
CAMPAIGN_TOPICS = ("truth", "mocap", "state", "reference_safe", "command")


def digests() -> Iterator[tuple[str, str]]:
    """Yield name and digest of each flight."""
    for name in SCENARIOS:
        scenario = library.load(name)
        short = replace(scenario, duration=min(scenario.duration, LONGEST_S))
        model = find_model(scenario.model).interaction
        for seed, (mode, controller, replan) in enumerate(WAYS):
            options = FlightOptions(mode, controller, replan, seed, model)
            yield f"{name} {mode} {controller} {replan} seed {seed}", digest(fly(short, options))
    for seed in CAMPAIGN_SEEDS:
        flown = fly_pure(draw_run(seed))
        signals = [digest(one.signal) for one in flown.signals if one.topic in CAMPAIGN_TOPICS]
        yield f"campaign {seed}", digest([*signals, *(one.policy for one in flown.violations)])


def digest(value: object) -> str:
    """Return the SHA-256 of every number and word of a value, in order; names of fields do not count."""
    found = hashlib.sha256()
    for part in _parts(value):
        found.update(part)
    return found.hexdigest()[:16]


def _parts(value: object) -> Iterator[bytes]:
    if isinstance(value, np.ndarray):
        yield str(value.dtype).encode() + str(value.shape).encode() + np.ascontiguousarray(value).tobytes()
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _parts(one)
    elif hasattr(type(value), "__dataclass_fields__"):
        for field in fields(value):  # type: ignore[arg-type]
            yield from _parts(getattr(value, field.name))
    else:
        yield repr(value).encode()


def main() -> int:
    """Record, or compare and return 1 where a flight differs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("action", choices=("record", "compare"))
    parser.add_argument("file", type=Path)
    asked = parser.parse_args()
    if asked.action == "record":
        found = dict(digests())
        asked.file.write_text(json.dumps(found, indent=1), encoding="utf-8")
        print(f"{len(found)} flights recorded in {asked.file}")
        return 0
    kept = json.loads(asked.file.read_text(encoding="utf-8"))
    found = dict(digests())
    different = [name for name in kept if kept[name] != found.get(name)]
    for name in different:
        print(f"differs: {name}")
    print(f"{len(kept) - len(different)} of {len(kept)} flights are equal, bit for bit")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
