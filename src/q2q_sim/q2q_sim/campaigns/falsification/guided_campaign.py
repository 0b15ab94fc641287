"""Guided campaign: searches of the stack as it is, and the score of the same search on seeded bugs.

Finished searches and scores are kept in files of JSON lines, from which an interrupted campaign resumes.
"""

import json
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from rich.table import Table

from q2q_model.documents.json_file import write_json
from q2q_model.documents.plain_values import from_plain
from q2q_model.plain_console import plain_console
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.campaigns.falsification.bug_score import BugScore, score_bugs, unscored
from q2q_sim.campaigns.falsification.candidate_flight import fly_candidate
from q2q_sim.campaigns.falsification.counterexample import read_case
from q2q_sim.campaigns.falsification.guided_search import LENGTH, SEARCH
from q2q_sim.campaigns.falsification.search_record import (
    SearchRecord,
    record_of_dead_process,
    search_and_keep,
    write_case_page,
)
from q2q_sim.campaigns.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.processes.parallel_work import Workers, spread_work
from q2q_sim.processes.resume_log import exclusive_log, read_entries

SEARCHES = "searches.jsonl"
"""File of finished searches."""


def run(args: Namespace) -> int:
    """Fly the requested guided campaign; return 1 if a policy or postcondition is violated.

    Raises:
        ValueError: the air or a file of finished work is not valid or in use.
    """
    if args.air:
        find_air(args.air)
    args.out.mkdir(parents=True, exist_ok=True)
    with exclusive_log(args.out / SEARCHES):
        searches, scores = list(_searches(args)), list(_scores(args))
    total = summary(searches, scores)
    if args.json:
        write_json(total, args.json)
    print_totals(total)
    return int(bool(total["violations"]))


def refly_case(args: Namespace) -> int:
    """Fly a case file again, print what it violates, write its replay page; return 1 if it violates anything.

    Raises:
        ValueError: the file is not a case.
    """
    case = read_case(args.case)
    flight = fly_candidate(case.run)
    print("\n".join(map(str, flight.violations)) or f"{args.case}: no violation")
    page = args.out / f"{args.case.stem}.html"
    write_case_page(case.run, flight.violations, page)
    if page.is_file():
        print(f"replay: {page}")
    return int(bool(flight.violations))


def summary(searches: Sequence[SearchRecord], scores: Sequence[BugScore]) -> dict[str, object]:
    """Return the totals of a guided campaign: the contract of `campaign --guided --json`."""
    return {
        "runs": sum(one.runs for one in searches),
        "violations": sum(bool(one.policies) for one in searches),
        "thrust_exceeded": sum(one.thrust_exceeded for one in searches),
        "unpredicted_downwash": sum(one.unpredicted_downwash for one in searches),
        "seeded_bugs": len(scores),
        "seeded_found": sum(one.guided > 0 for one in scores),
        "blind_found": sum(one.blind > 0 for one in scores),
        "bug_runs": max((one.runs for one in scores), default=0),
        "by_policy": dict(sorted(Counter(policy for one in searches for policy in one.policies).items())),
        "cases": sorted(one.case for one in searches if one.case),
        "bugs": {one.bug: {"guided": one.guided, "blind": one.blind} for one in scores},
        "seconds": sum(one.seconds for one in searches) + sum(one.seconds for one in scores),
    }


def print_totals(total: dict[str, object]) -> None:
    """Print the totals of a guided campaign."""
    table = Table(title="Runs until a seeded bug was found", show_lines=False)
    for column in ("bug", "guided", "blind"):
        table.add_column(column, justify="left" if column == "bug" else "right")
    bugs = total["bugs"]
    for name, found in bugs.items() if isinstance(bugs, dict) else ():
        table.add_row(name, str(found["guided"] or "-"), str(found["blind"] or "-"))
    if bugs:
        plain_console().print(table)
        print(
            f"seeded bugs found in {total['bug_runs']} runs each: {total['seeded_found']} of "
            f"{total['seeded_bugs']}, blind {total['blind_found']}"
        )
    print(f"violations: {total['violations']} in {total['runs']} runs")
    if total["thrust_exceeded"]:
        print(
            f"in {total['thrust_exceeded']} of them a vehicle had too little thrust and was not judged "
            "meanwhile"
        )
    if total["unpredicted_downwash"]:
        print(
            f"in {total['unpredicted_downwash']} of them a vehicle without measurements met an unpredictable "
            "downwash and was not judged meanwhile"
        )
    cases = total["cases"]
    for case in cases if isinstance(cases, list) else ():
        print(f"case: {case}")


def _searches(args: Namespace) -> Iterator[SearchRecord]:
    """Yield the record of every search, flown now or before."""
    log = args.out / SEARCHES
    lengths = {args.seed + k: min(LENGTH, args.runs - k * LENGTH) for k in range(-(-args.runs // LENGTH))}
    done = {
        one.seed: one
        for one in read_entries(log, lambda document: from_plain(SearchRecord, document, ""))
        if (one.air, one.search) == (args.air, SEARCH) and lengths.get(one.seed) == one.length
    }
    yield from done.values()
    work = partial(_search, lengths=lengths, kept=args.out / "cases", air=args.air)
    left = [seed for seed in lengths if seed not in done]
    for one in spread_work(Workers(args.engine, args.jobs), work, left, record_of_dead_process):
        _append(log, one)
        yield one


def _search(seed: int, lengths: dict[int, int], kept: Path, air: str) -> SearchRecord:
    return search_and_keep(seed, lengths[seed], kept, air)


def _scores(args: Namespace) -> Iterator[BugScore]:
    """Yield the score of every seeded bug, in their order, found now or before."""
    if not args.bug_runs:
        return
    log, wanted = args.out / "seeded_bugs.jsonl", (args.bug_runs, args.seed, args.air, SEARCH)
    found = read_entries(log, lambda document: from_plain(BugScore, document, ""))
    done = {one.bug: one for one in found if (one.runs, one.seed, one.air, one.search) == wanted}
    left = [number for number, bug in enumerate(SEEDED_BUGS) if bug.name not in done]
    work = partial(score_bugs, runs=args.bug_runs, seed=args.seed, air=args.air)
    for one in spread_work(Workers(args.engine, args.jobs), work, left, unscored):
        _append(log, one)
        done[one.bug] = one
    yield from (done[bug.name] for bug in SEEDED_BUGS)


def _append(log: Path, entry: SearchRecord | BugScore) -> None:
    with log.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(entry)) + "\n")
