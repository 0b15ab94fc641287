"""Judge the safe replanner's promise in random encounters: `python benchmarks/encounters.py --count 1000`.

Encounter k is made from seed k, so that any one of them can be flown again: `--first k --count 1`.
"""

import sys
from argparse import Namespace
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from q2q_model.commands.command_line import CommandLine, run_command
from q2q_planner.experiments.encounter_verdict import EncounterVerdict, judge_encounter
from q2q_planner.experiments.random_encounters import random_encounter
from q2q_planner.experiments.replanned_encounter import fly_encounter
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from row import Row

PARAMS = SafeReplannerParams(eps=0.2, tracking=0.02)
"""A zone somewhat wider than the paper's, in the small rooms of the encounters."""
SHORT = 20
"""Encounters of `scripts/bench`."""
PROGRESS_STEP = 25
"""Interval of progress reports."""
EXAMPLE = """  python benchmarks/encounters.py --count 1000 --jobs 2
  python benchmarks/encounters.py --first 17 --count 1"""


def run() -> list[Row]:
    """Return the rows of this area: a short campaign."""
    return rows_of(list(map(verdict_of, range(SHORT))))


def verdict_of(seed: int) -> EncounterVerdict:
    """Fly and judge one encounter."""
    generator = np.random.default_rng(seed)
    encounter = random_encounter(generator)
    return judge_encounter(fly_encounter(encounter, PARAMS, generator), encounter, PARAMS)


def rows_of(verdicts: Sequence[EncounterVerdict]) -> list[Row]:
    """Return the table of a campaign."""
    held = [one for one in verdicts if one.conditions_hold]
    failed = [one for one in verdicts if one.broken]
    return [
        Row("encounters", len(verdicts), ""),
        Row("of them apart, with messages 0 to 300 ms late", sum(one.apart for one in verdicts), ""),
        Row("in which the promise's conditions hold", len(held), ""),
        Row("  time in the zone", sum(one.zone_time for one in held), "s"),
        Row("  in which a promise was broken all the same", sum(one.broken for one in held), ""),
        *_extremes(held),
        Row("  whose references end clear of each other", sum(one.arrived is not None for one in held), ""),
        Row("    all back at them 1 s later", sum(one.arrived is True for one in held), ""),
        Row("with a broken promise, announced", len(failed), ""),
        Row("time in the zone, announced", sum(one.zone_time - one.silent_time for one in verdicts), "s"),
        Row("time in the zone, not announced", sum(one.silent_time for one in verdicts), "s"),
    ]


def _extremes(held: Sequence[EncounterVerdict]) -> list[Row]:
    """Return the rows of the worst of some encounters; none without encounters."""
    if not held:
        return []
    return [
        Row("  least distance to the zone", min(one.clearance for one in held) * 1e3, "mm"),
        Row("  largest lateral shift", max(one.shift for one in held), "m"),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a campaign; return 1 where a promise was broken, or a failure not announced."""
    return run_command(_parser(), lambda _: _campaign, arguments)


def _parser() -> CommandLine:
    made = CommandLine("encounters", __doc__, EXAMPLE)
    made.add_argument("--first", type=int, default=0, help="seed of the first encounter (default 0)")
    made.add_argument("--count", type=int, default=1000, help="how many (default 1000)")
    made.add_argument("--jobs", type=int, default=1, help="processes at once (default 1)")
    return made


def _campaign(args: Namespace) -> int:
    seeds = range(args.first, args.first + args.count)
    if args.jobs == 1:
        verdicts = _with_progress(map(verdict_of, seeds), args.first)
    else:
        with ProcessPoolExecutor(args.jobs) as pool:
            verdicts = _with_progress(pool.map(verdict_of, seeds, chunksize=4), args.first)
            pool.shutdown(wait=False, cancel_futures=True)
    for row in rows_of(verdicts):
        print(f"{row.name:52} {row.value:10.4g} {row.unit}")
    return int(any(map(_fails, verdicts)))


def _with_progress(verdicts: Iterable[EncounterVerdict], first: int) -> list[EncounterVerdict]:
    """Return the verdicts, naming each that fails as it comes; interrupted, those that there are."""
    found: list[EncounterVerdict] = []
    try:
        for verdict in verdicts:
            if _fails(verdict):
                print(f"seed {first + len(found)}: {verdict}", flush=True)
            found.append(verdict)
            if len(found) % PROGRESS_STEP == 0:
                print(f"encounters: {len(found)} judged", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("encounters: interrupted", file=sys.stderr)
    return found


def _fails(verdict: EncounterVerdict) -> bool:
    return verdict.silent_time > 0.0 or (verdict.conditions_hold and verdict.broken)


if __name__ == "__main__":
    sys.exit(main())
