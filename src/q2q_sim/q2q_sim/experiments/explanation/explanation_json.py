"""JSON of an explanation: the contract of `explain --json`."""

from q2q_model.documents.json_file import Json
from q2q_sim.experiments.explanation.explanation import Explanation
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence


def explanation_json(found: Explanation, difference: float) -> Json:
    """Return an explanation as plain values; `difference` is that of the flight flown again [m]."""
    return {
        "sentence": explanation_sentence(found),
        "vehicle": found.loss.vehicle,
        "t_s": found.loss.t,
        "loss_m": found.loss.size,
        "loss_of": found.loss.kind,
        "first": found.shares[0].cause if found.shares else None,
        "causes": [
            {"cause": one.cause, "share_m": one.share, "low_m": one.low, "high_m": one.high}
            for one in found.shares
        ],
        "rest_m": found.rest,
        "without_first_m": found.without_first,
        "difference_from_bag_m": difference,
    }
