"""Explanation of a bag and score of explanations: what is flown, reported and written."""

from argparse import Namespace

from rich.console import Console
from rich.progress import Progress

from q2q_model.documents.json_file import Json, write_json
from q2q_sim.experiments.explanation.explanation import Explanation, ExplanationParams, explain
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence
from q2q_sim.experiments.explanation.recorded_setup import recorded_setup
from q2q_sim.experiments.explanation.score import answer_accidents, score_json, score_text


def explain_bag(args: Namespace) -> int:
    """Explain a bag, print the sentence and write page and numbers; return the exit status."""
    recorded = recorded_setup(args.bag)
    with Progress(console=Console(stderr=True)) as bar:
        task = bar.add_task("explain", total=1.0)
        params = ExplanationParams(args.orders, args.draws, args.of)
        found = explain(recorded.setup, params, lambda share: bar.update(task, completed=share))
    if args.json:
        write_json(explanation_json(found, recorded.difference), args.json)
    if args.out:
        from q2q_sim.experiments.explanation.explanation_page import write_page

        print(f"page: {write_page(found, recorded, args.bag.name, args.out)}")
    print(explanation_sentence(found))
    return 0


def explanation_json(found: Explanation, difference: float) -> Json:
    """Return what `explain --json` writes, a contract; `difference` is that of the flight flown again [m]."""
    return {
        "sentence": explanation_sentence(found),
        "vehicle": found.loss.vehicle,
        "t_s": found.loss.t,
        "loss_m": found.loss.size,
        "loss_of": found.loss.kind,
        "ordinary": found.loss.is_ordinary,
        "first": found.first,
        "causes": [
            {"cause": one.cause, "share_m": one.share, "low_m": one.low, "high_m": one.high}
            for one in found.shares
        ],
        "rest_m": found.rest,
        "without_first_m": found.without_first,
        "difference_from_bag_m": difference,
    }


def score_explanations(args: Namespace) -> int:
    """Explain accidents whose first cause is known, print and write the score; return the exit status."""
    found = []
    for one in answer_accidents(range(args.seed, args.seed + args.score)):
        found.append(one)
        print(
            f"seed {one.seed}: {one.first}" + ("" if one.right else f", named first: {one.named}"), flush=True
        )
    if args.json:
        write_json(score_json(found), args.json)
    print(score_text(found))
    return 0
