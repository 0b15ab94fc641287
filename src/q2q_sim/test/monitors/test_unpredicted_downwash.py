"""Lost vehicles in a downwash that nothing can predict are told from those that a controller answers for."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.signals.values import CommandStatus
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import Circumstances, FlightTrace, judge
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import (
    PUSH,
    exempt_lately,
    unpredicted_downwash,
    unpredicted_downwash_lately,
)

TICKS = np.arange(1000) * 0.01
LOST = slice(300, 400)
"""Ticks at which cf1, 0.5 m below cf2 and 0.3 m beside it, is lost."""
IGNORING = Circumstances(aware=False)


def flight(push: float = 1.0, cf2: tuple[float, float, float] = (0.3, 0.0, 1.5)) -> FlightTrace:
    """Return a flight of two vehicles at rest, cf1 lost for a second under a downwash of `push` [m/s^2]."""
    n, shape = len(TICKS), (len(TICKS), 2)
    pos = np.tile([(0.0, 0.0, 1.0), cf2], (n, 1, 1))
    status = np.zeros(shape)
    status[LOST, 0] = CommandStatus.LEVEL
    downwash = np.zeros((n, 2, 3))
    downwash[:, 0, 2] = -push
    zero = np.zeros(shape)
    return FlightTrace(
        t=TICKS, names=("cf1", "cf2"), true_pos=pos, sent_pos=pos.copy(), asked_pos=pos.copy(),
        seen=status == 0.0, state_pos=pos.copy(), state_age=zero, state_status=zero,
        thrust=zero, roll=zero, pitch=zero,
        command_status=status, recorded_at=TICKS, commanded_at={}, live=False, not_finite=(),
        true_downwash=downwash,
    )  # fmt: skip


def displaced(name: str, start: float = 2.0, duration: float = 3.0) -> Circumstances:
    return Circumstances(faults=(Fault("jump", start, duration, (name,), 0.2),))


def test_it_is_unpredicted_by_a_controller_that_ignores_it_from_a_push_on_while_lost() -> None:
    found = unpredicted_downwash(flight(), IGNORING)
    assert found[LOST, 0].all()
    assert found.sum() == 100
    assert not unpredicted_downwash(flight(), Circumstances()).any()
    assert not unpredicted_downwash(flight(0.99 * PUSH), IGNORING).any()
    assert unpredicted_downwash(flight(1.01 * PUSH), IGNORING).any()


@pytest.mark.parametrize(
    ("cf2", "around", "found"),
    [
        ((0.3, 0.0, 1.5), displaced("cf2"), True),
        ((0.99, 0.0, 1.5), displaced("cf2"), True),  # 0.6 m, from which it is evaded, and 0.4 m of drift
        ((1.01, 0.0, 1.5), displaced("cf2"), False),
        ((0.3, 0.0, 0.5), displaced("cf2"), False),
        ((0.3, 0.0, 1.5), displaced("cf1"), True),
        ((0.3, 0.0, 0.5), displaced("cf1"), False),
        ((0.3, 0.0, 1.5), displaced("cf2", start=5.0), False),
    ],
    ids=["above", "far above", "too far", "below", "its own", "its own above", "later"],
)
def test_it_is_unpredicted_below_another_if_the_marker_of_either_is_displaced(
    cf2: tuple[float, float, float], around: Circumstances, found: bool
) -> None:
    assert unpredicted_downwash(flight(cf2=cf2), around)[LOST, 0].all() == found
    assert unpredicted_downwash(flight(cf2=cf2), around).any() == found


def test_a_fall_or_a_contact_by_it_is_exempt_until_it_had_its_time_and_no_other() -> None:
    trace = flight()
    for tick, exempt in ((390, True), (700, True), (800, False)):
        fallen, touching = trace.true_pos.copy(), trace.true_pos.copy()
        fallen[tick, 0, 2], touching[tick, 1] = 0.0, touching[tick, 0] + [0.0, 0.0, 0.1]
        for pos, policy in ((fallen, "floor"), (touching, "separation")):
            flown = replace(trace, true_pos=pos)
            broken = {one.policy for one in judge(flown, IGNORING)}
            assert (policy not in broken) == exempt
            assert policy in {one.policy for one in judge(flown, Circumstances())}


def test_lately_is_until_settle_after_it() -> None:
    lately = unpredicted_downwash_lately(flight(), IGNORING)
    assert lately[300:749, 0].all()  # 3.5 s after 3.99 s
    assert lately.sum() == 449
    np.testing.assert_array_equal(exempt_lately(flight(), IGNORING), lately)
    heavy = exempt_lately(flight(push=20.0), Circumstances())  # beyond its thrust
    assert heavy[:, 0].all()
