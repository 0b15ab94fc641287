"""Resumable campaign: finished runs are kept, violations printed."""

import json
from argparse import Namespace
from collections.abc import Container, Iterable, Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from q2q_model.counted import counted
from q2q_model.documents.json_file import write_json
from q2q_model.plain_console import plain_console
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.campaigns.random_runs.parallel_runs import run_outcomes
from q2q_sim.campaigns.random_runs.run_outcome import RunOutcome, from_document, summary
from q2q_sim.campaigns.random_runs.through_nodes import NodeFlights
from q2q_sim.processes.resume_log import exclusive_log, read_entries


def run(args: Namespace) -> int:
    """Fly the requested campaign; return 1 if a policy is violated.

    Raises:
        ValueError: the air or the file of finished runs is not valid, in use, or that of another air.
    """
    if args.air:
        find_air(args.air)
    flown, seconds = _fly(args)
    if args.json:
        write_json(summary(flown, seconds), args.json)
    print_campaign(flown, seconds)
    return int(any(one.violations for one in flown))


def _fly(args: Namespace) -> tuple[list[RunOutcome], float]:
    args.out.mkdir(parents=True, exist_ok=True)
    log, kept = args.out / "runs.jsonl", args.out / "violations"
    seeds = range(args.seed, args.seed + args.runs)
    by_nodes = set(seeds[: args.through_nodes])
    with exclusive_log(log) as file, _bar() as bar:
        done = _finished(log, args.air, by_nodes, seeds)
        pure = [seed for seed in seeds if seed not in done and seed not in by_nodes]
        nodes = [seed for seed in seeds if seed not in done and seed in by_nodes]
        task = bar.add_task("campaign", total=len(seeds), completed=len(done), violations=0)
        for one in _all(args, pure, nodes, kept):
            file.write(json.dumps(asdict(one)) + "\n")
            file.flush()
            done[one.seed] = one
            print_violation(one, bar.console)
            bar.update(task, advance=1, violations=sum(bool(each.violations) for each in done.values()))
    flown = [done[seed] for seed in seeds]
    return flown, sum(one.seconds for one in flown)


def _finished(log: Path, air: str, by_nodes: Container[int], seeds: Sequence[int]) -> dict[int, RunOutcome]:
    """Return the finished runs of `seeds`, of which some are to be flown through the nodes."""
    runs = read_entries(log, from_document)
    _reject_other_air(log, runs, air)
    return {
        one.seed: one for one in runs if one.seed in seeds and one.through_nodes >= (one.seed in by_nodes)
    }


def _all(args: Namespace, pure: Sequence[int], nodes: Sequence[int], kept: Path) -> Iterable[RunOutcome]:
    if pure:
        yield from run_outcomes(args.engine, pure, args.jobs, kept, args.air)
    if nodes:
        with NodeFlights(args.out / "nodes", kept, args.air) as flights:
            yield from map(flights.fly_and_judge, nodes)


def _reject_other_air(log: Path, runs: Sequence[RunOutcome], air: str) -> None:
    """Raise ValueError if a kept run was flown in another air than this campaign's."""
    others = sorted({one.air or "of each scenario" for one in runs if one.air != air})
    if others:
        raise ValueError(f"{log} holds runs in the air {', '.join(others)}: give another --out")


def print_violation(outcome: RunOutcome, console: Console) -> None:
    """Print a run that violated a policy."""
    if outcome.violations:
        console.print(f"seed {outcome.seed}: {outcome.what}")
        for one in outcome.violations:
            console.print(f"    {one}")


def print_campaign(flown: Sequence[RunOutcome], seconds: float) -> None:
    """Print the table of a campaign."""
    total = summary(flown, seconds)
    runs = counted(len(flown), "run")
    table = Table(title=f"{runs}, {total['through_nodes']} through the nodes, {seconds:.0f} s")
    table.add_column("policy")
    table.add_column("runs that violate it", justify="right")
    counts = total["by_policy"]
    for policy, count in counts.items() if isinstance(counts, dict) else ():
        table.add_row(policy, str(count))
    table.add_row("any", str(total["violations"]))
    plain_console().print(table)
    if total["seeds_of_violations"]:
        print(f"seeds of violations: {total['seeds_of_violations']}")


def _bar() -> Progress:
    words = TextColumn("{task.description}, violations {task.fields[violations]}")
    console = plain_console(stderr=True)
    return Progress(words, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=console)
