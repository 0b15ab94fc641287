"""A guided search goes where margins fall, and what it finds shrinks, is kept and flies again."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from q2q_sim.campaigns.falsification import guided_campaign
from q2q_sim.campaigns.falsification import guided_search as search
from q2q_sim.campaigns.falsification.candidate_flight import (
    RECORD,
    CandidateFlight,
    fly_candidate,
)
from q2q_sim.campaigns.falsification.coincidence import CoincidingFaults, critical_moments
from q2q_sim.campaigns.falsification.counterexample import (
    case_of,
    read_case,
    shrink,
    with_faults,
    write_case,
)
from q2q_sim.campaigns.falsification.fault_vector import DIMENSION, SLOTS, faults_of, vector_of
from q2q_sim.campaigns.falsification.guided_search import (
    GENERATION,
    RANDOM_RUNS,
    falling_policies,
    guided_runs,
    guided_search,
    last_fault_start,
)
from q2q_sim.campaigns.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.commands import campaign
from q2q_sim.faults.drawn_faults import LENGTHS, SIZES
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.monitors.policies import Violation

NAMES = ("a", "b", "c")
BROKEN = Violation("tilt", "a", 1.0, 0.5, 0.36)


def distance(run: Run) -> float:
    """Return how far the starts of a run's faults are from 1 s."""
    return float(np.mean([abs(fault.start - 1.0) for fault in run.scenario.faults]))


def test_a_vector_covers_what_campaigns_draw():
    rng = np.random.default_rng(0)
    found = [fault for _ in range(300) for fault in faults_of(rng.random(DIMENSION), NAMES, 5.0)]
    assert {fault.kind for fault in found} == set(KINDS)
    for fault in found:
        assert 0.0 <= fault.start <= 5.0
        low, high = LENGTHS[fault.kind]
        assert low <= fault.duration <= high
        low, high = SIZES.get(fault.kind, (0.0, 0.0))
        assert low <= fault.size <= high
    assert {fault.vehicles for fault in found if fault.kind == "swap"} == {("a", "b"), ("a", "c"), ("b", "c")}
    assert {fault.vehicles for fault in found if fault.kind == "nan"} == {("a",), ("b",), ("c",)}


@pytest.mark.parametrize("end", [0.0, 1.0])
def test_the_ends_of_a_vector_are_faults_and_one_vehicle_swaps_with_none(end: float):
    faults = faults_of(np.full(DIMENSION, end), ("a",), 5.0)
    assert len(faults) == SLOTS
    assert {fault.start for fault in faults} == {5.0 * end}
    assert "swap" not in {fault.kind for fault in faults}


def test_faults_are_those_of_their_vector():
    run = draw_run(3)
    last = last_fault_start(run)
    faults = CoincidingFaults(np.random.default_rng(1), run.scenario, last).drawn(2)
    again = faults_of(vector_of(faults, run.scenario.names, last), run.scenario.names, last)
    for one, other in zip(faults, again, strict=True):
        assert (one.kind, one.vehicles) == (other.kind, other.vehicles)
        assert (one.start, one.duration, one.size) == pytest.approx((other.start, other.duration, other.size))


def test_coinciding_faults_begin_on_each_other_and_act_at_moments_of_the_plan():
    run = draw_run(0)
    last = last_fault_start(run)
    known = {moment.t for moment in critical_moments(run.scenario, last)}
    draw = CoincidingFaults(np.random.default_rng(0), run.scenario, last)
    for _ in range(100):
        one, other = draw.drawn(1)
        spans = [(fault.start - 1e-9, fault.start + fault.duration + 1e-9) for fault in (one, other)]
        assert any(begin <= t <= end for begin, end in spans for t in known)
        assert spans[0][0] <= spans[1][0] <= spans[0][1] or spans[1][0] <= spans[0][0] <= spans[1][1]
        for fault in (one, other):
            low, high = LENGTHS[fault.kind]
            assert low <= fault.duration <= high
            assert fault.start <= last


def test_the_moments_of_a_pass_are_its_fastest_and_its_nearest():
    run = next(
        run for run in map(draw_run, range(100)) if "Table 2 flight 3" in str(run.document["description"])
    )
    fastest, nearest = critical_moments(run.scenario, last_fault_start(run))
    crossing = 20.0 - 15.5  # the middle of the pass, in the section flown
    assert fastest.vehicle == nearest.vehicle == "cf2"
    assert fastest.t == pytest.approx(crossing, abs=0.051)
    assert nearest.t == pytest.approx(crossing, abs=0.051)


def test_a_search_lowers_the_margin_that_fell_most_in_the_run_where_it_is_least():
    flown: list[tuple[Run, float]] = []

    def judge(run: Run) -> CandidateFlight:
        flown.append((run, distance(run)))
        return CandidateFlight((), {"tilt": 0.01, "hold_too_long": distance(run)})

    length = RANDOM_RUNS + 6 * GENERATION
    assert guided_search(3, length, judge).runs == length == len(flown)
    drawn, lowering = flown[:RANDOM_RUNS], flown[RANDOM_RUNS:]
    worst = min(drawn, key=lambda one: one[1])
    assert {run.seed for run, _ in drawn} == set(range(3 * RANDOM_RUNS, 4 * RANDOM_RUNS))
    assert {run.options.replan for run, _ in drawn[1::2]} == {"safe"}
    assert {run.seed for run, _ in lowering} == {worst[0].seed}
    assert np.mean([margin for _, margin in lowering[-GENERATION:]]) < 0.8 * worst[1]
    for run, _ in flown:
        assert all(fault.start <= last_fault_start(run) for fault in run.scenario.faults)


def test_margins_that_all_runs_share_are_not_searched():
    flights = [
        CandidateFlight((), {"tilt": 0.0, "hold_too_long": 1.0 - 0.1 * k, "setpoint_error": 0.9 - 0.2 * k})
        for k in range(5)
    ]
    drawn = [search.GuidedRun(draw_run(0), np.zeros(DIMENSION), flight) for flight in flights]
    assert falling_policies(drawn) == ("setpoint_error", "hold_too_long")


def test_a_search_is_its_seed_and_ends_with_its_runs_or_a_violation():
    def judge(run: Run) -> CandidateFlight:
        return CandidateFlight((BROKEN,) if distance(run) < 1.0 else (), {"setpoint_error": distance(run)})

    one = guided_search(5, 50, judge)
    assert one == guided_search(5, 50, judge)
    assert one.violated is not None
    assert distance(one.violated) < 1.0
    assert one.policies == {"tilt"}
    assert guided_search(5, one.runs - 1, judge).violated is None


def test_a_shrunk_run_has_the_faults_that_count_rounded_as_far_as_they_may_be():
    jump = Fault("jump", 1.04999, 0.5123, ("cf1",), 0.26123)
    others = (Fault("dropout", 2.0, 0.3), Fault("nan", 0.5), Fault("stale", 3.0, 0.1))
    run = with_faults(draw_run(0), (others[0], jump, *others[1:]))

    def still(run: Run) -> bool:
        return any(fault.kind == "jump" and fault.size > 0.25 for fault in run.scenario.faults)

    (left,) = shrink(run, still).scenario.faults
    assert left == replace(jump, start=1.0, duration=0.5, size=0.3)
    (left,) = shrink(run, lambda one: still(one) and one.scenario.faults[-1].start > 1.04).scenario.faults
    assert left == replace(jump, start=1.05, duration=0.51, size=0.26)


def test_a_seeded_bug_is_found_kept_and_flown_again(tmp_path: Path):
    run = draw_run(0)
    run = with_faults(run, (Fault("nan", 1.0, 0.1, run.scenario.names[:1]),))
    bug = next(bug for bug in SEEDED_BUGS if bug.name == "nan_as_zero")
    with bug.seeded():
        assert fly_candidate(run).policies == {RECORD}
        write_case(case_of(run, {RECORD}), tmp_path / "cases" / "case_0.yaml")
    case = read_case(tmp_path / "cases" / "case_0.yaml")
    assert (case.run.scenario, case.run.options) == (run.scenario, run.options)
    assert case.violates == (RECORD,)
    assert fly_candidate(case.run).violations == ()
    with bug.seeded():
        assert fly_candidate(case.run).policies == {RECORD}


@pytest.mark.parametrize("out", [(), ("--out", "elsewhere")])
def test_the_page_of_a_case_flown_again_is_beside_it_or_in_out(
    out: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    written: list[Path] = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(guided_campaign, "fly_candidate", lambda _: CandidateFlight(()))
    monkeypatch.setattr(guided_campaign, "write_case_page", lambda _run, _found, page: written.append(page))
    write_case(case_of(draw_run(0), {RECORD}), Path("cases/case_0.yaml"))
    assert campaign.main(["--case", "cases/case_0.yaml", *out]) == 0
    assert written == [Path(out[1] if out else "cases") / "case_0.html"]


def test_a_file_that_is_no_case_is_refused(tmp_path: Path):
    path = tmp_path / "case.yaml"
    path.write_text("seed: 1\n")
    with pytest.raises(ValueError, match=r"case\.yaml"):
        read_case(path)


def test_a_seeded_bug_is_removed_when_its_context_exits():
    assert len({bug.name for bug in SEEDED_BUGS}) == len(SEEDED_BUGS) == 20
    for bug in SEEDED_BUGS:
        sound = vars(bug.place)[bug.function]
        with bug.seeded():
            assert vars(bug.place)[bug.function] is bug.wrong
        assert vars(bug.place)[bug.function] is sound


def test_generations_are_of_runs_that_differ():
    judge = iter(range(RANDOM_RUNS + GENERATION))
    tried = guided_runs(
        1, RANDOM_RUNS + GENERATION, lambda _: CandidateFlight((), {"setpoint_error": -float(next(judge))})
    )
    seen = [one.vector for one in tried]
    assert len(seen) == RANDOM_RUNS + GENERATION
    assert all(not np.array_equal(one, other) for one, other in pairwise(seen))
    assert search.LENGTH >= RANDOM_RUNS + GENERATION
