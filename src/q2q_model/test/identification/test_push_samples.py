"""The rule by which rows of a flight count, and their score."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import (
    PushRecord,
    PushSamples,
    known_rows,
    push_samples,
    score,
    scored_rows,
    unmeasured_note,
)
from q2q_model.signals.values import Array


def record(rel: Array, push: Array, height: float = 1.0) -> PushRecord:
    """Return a record in which vehicle 0 hovers and vehicle 1 is at `rel` (T, 3) from it."""
    ticks = rel.shape[0]
    pos = np.zeros((ticks, 2, 3))
    pos[:, 0, 2] = height
    pos[:, 1] = pos[:, 0] + rel
    up = np.tile([0.0, 0.0, 1.0], (ticks, 2, 1))
    motion = Motion(0.01 * np.arange(ticks), pos, np.zeros_like(pos), up)
    good = np.ones((ticks, 2), dtype=bool)
    return PushRecord("made", ("a", "b"), motion, np.stack([push, 0.0 * push], axis=1), good, ~good)


def passing(ticks: int = 1000) -> Array:
    """Return a source half a metre above that passes from -1 m to 1 m."""
    return np.stack([np.zeros(ticks), np.linspace(-1.0, 1.0, ticks), np.full(ticks, 0.5)], axis=1)


def lower_of(made: PushRecord) -> PushSamples:
    """Return the samples of vehicle 0."""
    return next(one for one in push_samples(made) if one.vehicle == 0)


def test_exposed_free_and_upper_rows_are_those_of_the_rule() -> None:
    rel = passing()
    lower = lower_of(record(rel, np.zeros(1000)))
    np.testing.assert_array_equal(lower.exposed, np.abs(rel[:, 1]) < 0.15)
    upper = next(one for one in push_samples(record(rel, np.zeros(1000))) if one.vehicle == 1)
    assert not upper.exposed.any()
    np.testing.assert_array_equal(upper.upper, np.abs(rel[:, 1]) < 0.1)
    assert not lower.upper.any()


def test_a_constant_of_the_vehicle_is_taken_off_by_its_free_rows() -> None:
    rel = passing()
    push = np.where(np.abs(rel[:, 1]) < 0.15, -2.0, 0.0) + 0.7
    y = lower_of(record(rel, push)).y
    np.testing.assert_allclose(y[np.abs(rel[:, 1]) > 0.3], 0.0, atol=1e-12)
    np.testing.assert_allclose(y[np.abs(rel[:, 1]) < 0.1], -2.0, atol=1e-12)


def test_rows_that_are_low_mended_or_saturated_do_not_count() -> None:
    made = record(passing(), np.zeros(1000))
    low = push_samples(record(passing(), np.zeros(1000), height=0.2))
    assert [one.vehicle for one in low] == [1]  # the other has no usable row at all
    measured, saturated = made.measured.copy(), made.saturated.copy()
    measured[480:490, 1] = False  # of the neighbour: its place is not known either
    saturated[510:520, 0] = True
    lower = lower_of(replace(made, measured=measured, saturated=saturated))
    assert not lower.usable[480:490].any()
    assert not lower.usable[510:520].any()
    assert lower.usable.sum() == 980


def test_a_vehicle_with_too_few_free_rows_is_not_scored() -> None:
    always_above = np.tile([0.0, 0.0, 0.5], (1000, 1))
    assert [one.vehicle for one in push_samples(record(always_above, np.zeros(1000)))] == [1]


def test_r2_is_one_for_the_law_that_pushed_and_zero_for_none() -> None:
    rel = passing()
    made = record(rel, np.zeros(1000))
    push = eta_along(MEASURED_LAW, made.motion)[:, 0, 2]
    samples = [lower_of(record(rel, push))]
    assert score(MEASURED_LAW, samples).r2_exposed == pytest.approx(1.0, abs=1e-12)
    assert score(MEASURED_LAW, samples).r2_ahead_20ms == pytest.approx(1.0, abs=1e-12)
    assert score(NoInteraction(), samples).r2_exposed == 0.0
    assert score(MEASURED_LAW, samples).n == int((np.abs(rel[:, 1]) < 0.15).sum())


def test_a_vehicle_that_is_away_spoils_no_row_of_others() -> None:
    made = record(passing(), np.zeros(1000))
    third = np.zeros((1000, 1, 3))
    third[:, :, 0] = 3.0
    third[600:, :, 0] = 0.4  # comes within half a metre of vehicle 0
    motion = replace(
        made.motion,
        pos=np.concatenate([made.motion.pos, third], axis=1),
        vel=np.zeros((1000, 3, 3)),
        axis=np.tile([0.0, 0.0, 1.0], (1000, 3, 1)),
    )
    unseen = np.zeros((1000, 1), dtype=bool)
    unseen[400:500] = True  # one second without a measurement before, none of two
    joined = replace(
        made,
        names=("a", "b", "c"),
        motion=motion,
        push=np.zeros((1000, 3)),
        measured=np.concatenate([made.measured, unseen], axis=1),
        saturated=np.zeros((1000, 3), dtype=bool),
    )
    np.testing.assert_array_equal(known_rows(joined)[:, 0], np.arange(1000) < 600)
    assert known_rows(joined)[400:500, 2].all()
    assert known_rows(joined)[:, 2].sum() == 100
    brief = joined.measured.copy()
    brief[:, 2] = True
    brief[100:250, 2] = False  # 1.5 s: a gap, in which it may be anywhere
    gap = known_rows(replace(joined, measured=brief))
    np.testing.assert_array_equal(gap[:, 0], brief[:, 2])
    assert unmeasured_note(joined) == ""
    never = replace(joined, measured=np.concatenate([made.measured, np.zeros((1000, 1), dtype=bool)], axis=1))
    assert unmeasured_note(never) == "made: no measurements of c"
    assert push_samples(never)[0].usable.sum() == 600


def test_without_exposed_rows_nothing_is_claimed() -> None:
    far = np.tile([2.0, 0.0, 0.5], (1000, 1))
    found = score(MEASURED_LAW, push_samples(record(far, np.zeros(1000))))
    assert found.r2_exposed is None
    assert found.n == 0
    assert score(MEASURED_LAW, []).mean_upper_mps2 is None


def test_vehicles_that_feel_nothing_at_all_leave_r2_undefined() -> None:
    """As in a simulator without noise and downwash: R2 would divide by the square of what was felt."""
    found = score(NoInteraction(), push_samples(record(passing(), np.zeros(1000))))
    assert found.n > 0
    assert (found.r2_exposed, found.r2_ahead_20ms, found.rmse_exposed_mps2) == (None, None, 0.0)


def test_rows_of_many_vehicles_take_no_memory_for_all_pairs_at_once() -> None:
    ticks, n = 200, 100
    pos = np.ones((ticks, n, 3))
    pos[..., 0], pos[..., 1] = np.divmod(np.arange(n), 10)
    motion = Motion(np.linspace(0.0, 2.0, ticks), pos, np.zeros_like(pos), np.zeros_like(pos))
    good = np.ones((ticks, n), dtype=bool)
    made = PushRecord("made", tuple(f"cf{i}" for i in range(n)), motion, np.zeros((ticks, n)), good, ~good)
    tracemalloc.start()
    try:
        rows = scored_rows(made)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert all(one.free.all() and not one.exposed.any() for one in rows)
    assert most < ticks * n * n * 8  # bytes of one distance for every pair and tick
