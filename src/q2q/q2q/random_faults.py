"""Campaign of flights with random faults, each judged by the safety policies."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from q2q.argument_checks import check_whole_number, folder_to_write
from q2q.scenario_choice import AirName, air_name
from q2q_sim.air.air_names import check_air
from q2q_sim.campaigns.random_runs.campaign_flight import fly_and_judge
from q2q_sim.campaigns.random_runs.parallel_runs import run_outcomes
from q2q_sim.campaigns.random_runs.run_outcome import RunOutcome


def campaign(
    runs: int, *, seed: int = 0, air: AirName = "", jobs: int = 1, out: Path | str = "out/campaign"
) -> Iterator[RunOutcome]:
    """Return the outcomes of runs, each as it is completed.

    Args:
        runs: number of runs, 1 or more.
        seed: of the first run, 0 or above; it defines scenario, controller and faults, the others follow it.
        air: air in place of the scenarios' wake and disturbance: a name as for `q2q.scenario`.
        jobs: flights at a time: 1 in this process; above, in others, so call it under
            `if __name__ == "__main__":` in a script.
        out: folder for scenario and bag of each run that violates a policy.

    Raises:
        TypeError: an argument of another type; the message says what is expected.
        ValueError: a number that is too small, or `out` cannot be written to.
        AirError: there is no such air.
        RuntimeError: the processes of `jobs` cannot import the script, as without that guard.
    """
    for name, number, least in (("runs", runs, 1), ("seed", seed, 0), ("jobs", jobs, 1)):
        check_whole_number(name, number, least)
    if named := air_name(air):
        check_air(named)
    kept, seeds = folder_to_write("out", out), range(seed, seed + runs)
    if jobs == 1:
        return map(partial(fly_and_judge, kept=kept, air=named), seeds)
    return run_outcomes("local", seeds, jobs, kept, named)
