"""A plan file reads back as the same numbers, and what is no plan is refused in words."""

import json
from math import nan
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.trajectory.plan_file import PlanFacts, decode, encode, load, load_with_facts, save
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_a_round_trip_keeps_every_bit(seed: int, certified: bool) -> None:
    generator = np.random.default_rng(seed)
    curves = tuple(
        Trajectory(
            generator.uniform(0.1, 9.0, n),
            generator.normal(size=(n, 4, 8)) * 10.0 ** -generator.integers(0, 300),
        )
        for n in (1, 3)
    )
    facts = PlanFacts("cylinder", 1.0 / 3.0, 0.1, -0.25)
    plan, known = decode(encode(SwarmPlan(("cf1", "cf2"), curves, certified), facts))
    assert known == facts
    assert plan.certified is certified
    for ours, theirs in zip(curves, plan.trajectories, strict=True):
        assert np.array_equal(ours.durations, theirs.durations)
        assert np.array_equal(ours.coefficients, theirs.coefficients)


def test_a_plan_saved_in_a_new_folder_loads_and_unknown_facts_stay_unknown(tmp_path: Path) -> None:
    curve = Trajectory(np.array([1.0]), np.ones((1, 4, 3)))
    save(tmp_path / "new" / "plan.json", SwarmPlan(("cf1",), (curve,)))
    plan, facts = load_with_facts(tmp_path / "new" / "plan.json")
    assert plan.names == ("cf1",)
    assert facts.snap_cost is not None
    assert np.isnan(facts.snap_cost)
    assert str(facts.clearance) == str(nan)


def test_what_is_no_plan_is_refused(tmp_path: Path) -> None:
    whole = encode(SwarmPlan(("cf1",), (Trajectory(np.array([1.0]), np.ones((1, 4, 3))),)))
    document = json.loads(whole)
    bad = {
        "half.json": whole[: len(whole) // 2],
        "list.json": "[1, 2]",
        "other.json": '{"format": "other"}',
        "short.json": json.dumps({**document, "vehicles": [{"name": "cf1", "durations": [1.0]}]}),
        "ragged.json": json.dumps(
            {**document, "vehicles": [{"name": "cf1", "durations": [1.0], "coefficients": [[1], [1, 2]]}]}
        ),
        "nan.json": json.dumps(
            {**document, "vehicles": [{"name": "cf1", "durations": [nan], "coefficients": [[[1.0]] * 4]}]}
        ),
        "huge.json": whole.replace("1.0, 1.0, 1.0", "1e300, 1.0, 1.0", 1),
        "vast.json": whole.replace("1.0, 1.0, 1.0", "1" + "0" * 400 + ", 1.0, 1.0", 1),
        "vast_fact.json": whole.replace('"snap_cost": null', '"snap_cost": 1' + "0" * 400),
        "twice.json": json.dumps({**document, "vehicles": document["vehicles"] * 2}),
        "text.json": whole.replace('"durations": [1.0]', '"durations": ["1.0"]'),
        "true.json": whole.replace('"durations": [1.0]', '"durations": [true]'),
        "text_in.json": whole.replace("1.0, 1.0, 1.0", '"1.0", 1.0, 1.0', 1),
        "unnamed.json": whole.replace('"name": "cf1"', '"name": ""'),
        "path.json": whole.replace('"name": "cf1"', '"name": "../x y"'),
        "order.json": encode(SwarmPlan(("cf1",), (Trajectory(np.array([1.0]), np.ones((1, 4, 33))),))),
        "empty.json": json.dumps({**document, "vehicles": []}),
        "deep.json": "[" * 100_000,
    }
    for name, text in bad.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match=rf"{name} is not a plan: .*; write one with"):
            load(tmp_path / name)
    with pytest.raises(ValueError, match=r"absent\.json cannot be read"):
        load(tmp_path / "absent.json")


Anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=12,
)


@settings(deadline=None, max_examples=200)
@given(
    st.sampled_from(["format", "version", "certified", "zone", "snap_cost", "clearance_m", "vehicles"]),
    st.sampled_from([None, "name", "durations", "coefficients"]),
    Anything,
)
def test_a_plan_with_any_entry_replaced_is_read_or_refused(
    key: str, inner: str | None, value: object
) -> None:
    curve = Trajectory(np.array([1.0]), np.ones((1, 4, 3)))
    document = json.loads(encode(SwarmPlan(("cf1",), (curve,))))
    if inner is None:
        document[key] = value
    else:
        document["vehicles"][0][inner] = value
    text, lines = json.dumps(document), ""
    try:
        plan, _ = decode(text, "fuzzed")
    except ValueError as refusal:
        lines = str(refusal)
    assert lines.startswith("fuzzed is not a plan: ") if lines else np.isfinite(plan.duration)
