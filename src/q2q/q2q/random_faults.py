"""Campaign of flights with random faults, each judged by the safety policies."""

from collections.abc import Iterator
from pathlib import Path

from q2q_sim.experiments.campaign.engine import outcomes
from q2q_sim.experiments.campaign.run_outcome import RunOutcome


def campaign(
    runs: int, *, seed: int = 0, air: str = "", jobs: int = 1, out: Path | str = "out/campaign"
) -> Iterator[RunOutcome]:
    """Yield the outcome of each run, in the order of completion.

    Args:
        runs: number of runs.
        seed: of the first run, which defines its scenario, controller and faults; the others follow it.
        air: air in place of the scenarios' wake and disturbance: a name as for `q2q.scenario`.
        jobs: processes; above 1, call it under `if __name__ == "__main__":` in a script.
        out: folder for scenario and bag of each run that violates a policy.

    Raises:
        AirError: there is no such air.
    """
    yield from outcomes("local", range(seed, seed + runs), jobs, Path(out), air)
