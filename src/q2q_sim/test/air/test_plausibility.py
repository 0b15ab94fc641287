"""What was learned is judged: its sign, its size and the checks."""

from dataclasses import replace

import pytest
from synthetic_air import Wake, flown, orbit, wide_jet

from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.learning.jet.plausibility import doubts, reject_excess, reject_lift
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.fitted import Fitted


def scaled(record: AirRecord, factor: float) -> AirRecord:
    """Return a flight whose measured push is in another unit, or of another sign."""
    return replace(record, samples=tuple(replace(one, y=factor * one.y) for one in record.samples))


def check(path: str, value: float) -> Fitted:
    return Fitted(path, value, None, None, 0, "")


@pytest.fixture(scope="module")
def pair() -> AirRecord:
    """Return a flight of a pair in a known jet."""
    return flown("pair", orbit(60.0, (0.6, 1.05), 1), Wake(wide_jet(), None), 1)


def test_a_push_upwards_is_refused_with_what_to_check(pair: AirRecord) -> None:
    reject_lift([pair])
    with pytest.raises(
        ValueError, match=r"pushed up by \d\.\d\d m/s\^2 .* check the sign of .* faz_est \[N\]"
    ):
        reject_lift([scaled(pair, -1.0)])


def test_a_push_in_gram_force_is_refused_and_one_in_newton_is_not() -> None:
    jet = wide_jet()
    reject_excess(jet)
    with pytest.raises(ValueError, match=r"up to \d+ m/s\^2, .* gives 9\.81: check the unit of .* faz_est"):
        reject_excess(replace(jet, push_mps2=1e3 / GRAVITY * jet.push_mps2))


def test_checks_that_are_not_as_expected_are_named() -> None:
    push = check("jet.push_mps2", 2.7)
    usual = [
        check("momentum of one jet", 0.76),
        check("largest radial mean", 0.11),
        check("two wakes over their sum", 0.8),
    ]
    assert doubts([push], usual) == ()
    assert doubts([], []) == ()
    odd = [
        replace(one, value=factor * one.value) for one, factor in zip(usual, (0.1, -10.0, 2.0), strict=True)
    ]
    momentum, lateral, together = doubts([push], odd)
    assert momentum.startswith("one jet gives rotor disks 0.076 of its source's momentum")
    assert lateral.startswith("the lateral push, -1.1 m/s^2, is more than 20% of the push on the axis")
    assert together.startswith("two wakes together have 1.6 of their sum")
