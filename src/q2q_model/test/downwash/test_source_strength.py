"""Tests of the strengths of sources in stacks: closed forms, and two implementations that agree."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.downwash.source_strength import PAIRS_ALONE, SourceTerms, source_terms, strengths
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm, free_names
from q2q_model.identification.push.along_flight import (
    FlownRows,
    Motion,
    VehicleTicks,
    eta_along,
    eta_on_vehicle,
)
from q2q_model.identification.push.push_samples import PushRecord, push_samples
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

LOADED = replace(MOVING_LAW, velocity_share=0.6, loading=0.6, absorption=1.5)
STACK = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5], [0.0, 0.0, 2.1]])
"""Lowest, middle, top [m]."""


def alone(law: float, i: int, j: int) -> float:
    """Return the vertical downwash of one pair of the stack times a factor."""
    rel_pos = STACK[j] - STACK[i]
    return law * float(PAPER_LAW.acceleration(rel_pos, pairs_at_rest(rel_pos))[2])


def of_stack(terms: SourceTerms, pos: Array = STACK) -> dict[tuple[int, int], float]:
    """Return the strength of each pair of three hovering vehicles."""
    i, j = np.nonzero(~np.eye(3, dtype=bool))
    rel_pos = pos[j] - pos[i]
    law = PAPER_LAW.acceleration(rel_pos, pairs_at_rest(rel_pos))[:, 2:]
    share = strengths(i, j, law, np.ones_like(law), terms)[:, 0]
    return dict(zip(zip(i.tolist(), j.tolist(), strict=True), share.tolist(), strict=True))


def test_a_model_of_pairs_alone_has_strength_one_everywhere():
    assert source_terms(PAPER_LAW) == PAIRS_ALONE
    assert set(of_stack(PAIRS_ALONE).values()) == {1.0}


def test_a_flight_of_one_vehicle_has_no_pairs_and_no_strengths():
    nobody, never = np.zeros(0, np.intp), np.zeros((0, 5))
    assert strengths(nobody, nobody, never, never, SourceTerms(loading=0.6, absorption=0.3)).shape == (0, 5)


def test_a_source_pushed_down_is_stronger_by_the_loading_times_that_push_in_g():
    found = of_stack(SourceTerms(loading=0.7))
    assert found[0, 1] == pytest.approx(1.0 - 0.7 * alone(1.0, 1, 2) / GRAVITY, rel=1e-12)
    assert found[0, 2] == 1.0  # nobody pushes the top one down


def test_the_middle_vehicle_takes_from_the_top_ones_jet_and_from_no_other():
    found = of_stack(SourceTerms(absorption=1.5))
    assert found[0, 2] == pytest.approx(1.0 + 1.5 * alone(1.0, 1, 2) / GRAVITY, rel=1e-12)
    assert {pair: share for pair, share in found.items() if pair != (0, 2)} == dict.fromkeys(
        [(0, 1), (1, 0), (1, 2), (2, 0), (2, 1)], 1.0
    )


def test_a_vehicle_beside_takes_nothing_of_the_jet_that_both_are_in():
    beside = np.array([[0.15, 0.0, 1.0], [-0.15, 0.0, 1.0], [0.0, 0.0, 1.6]])
    assert of_stack(SourceTerms(absorption=1.5), beside)[0, 2] == pytest.approx(1.0, abs=1e-4)


def test_no_source_pulls_however_much_is_absorbed():
    near = STACK * [1.0, 1.0, 0.3]
    assert of_stack(SourceTerms(absorption=1e6), near)[0, 2] == 0.0


def flight(seconds: float = 12.0) -> Motion:
    """Return three vehicles that pass over each other, accelerating up and down."""
    t = 0.01 * np.arange(round(100 * seconds))
    pos = np.zeros((t.size, 3, 3))
    pos[:, :, 2] = [1.0, 1.4, 1.9]
    pos[:, 1, 0], pos[:, 2, 0] = 0.15 * np.sin(1.1 * t), 0.25 * np.sin(0.7 * t)
    pos[:, 1, 2] += 0.1 * np.sin(4.0 * t)
    pos[:, 2, 2] += 0.1 * np.sin(3.1 * t)
    return Motion(t, pos, np.gradient(pos, 0.01, axis=0), np.tile([0.0, 0.0, 1.0], (t.size, 3, 1)))


def test_the_predictor_online_gives_what_the_whole_record_gives():
    motion = flight(3.0)
    whole, predictor = eta_along(LOADED, motion), InteractionPredictor(LOADED)
    for k, t in enumerate(motion.t):
        names = ("low", "middle", "top")
        state = resting_state(float(t), names, motion.pos[k], vel=motion.vel[k])
        online = predictor.update(state).acc
        if t > 0.8:  # then the history is whole
            np.testing.assert_allclose(online, whole[k], rtol=1e-9, atol=1e-12)
    assert np.abs(whole - eta_along(replace(LOADED, loading=0.0), motion)).max() > 0.05
    assert np.abs(whole - eta_along(replace(LOADED, absorption=0.0), motion)).max() > 0.05


@pytest.mark.parametrize("law", [LOADED, replace(LOADED, loading=0.0, absorption=0.0)])
def test_rows_of_many_flights_are_evaluated_as_each_alone(law: Jet):
    """Each flight has its own clock, shifted by up to 1e3 s; first rows feel what left before the start."""
    one, other = flight(2.0), flight(3.0)
    late = replace(other, t=other.t + 700.0, pos=other.pos * [1.1, 1.0, 0.9])
    two = Motion(one.t, *(np.ascontiguousarray(part[:, :2]) for part in (one.pos, one.vel, one.axis)))
    ticks = np.arange(0, one.t.size, 7)
    parts = [
        VehicleTicks(motion, vehicle, ticks[vehicle:])
        for motion, vehicle in ((late, 1), (one, 0), (one, 1), (two, 0), (late, 0), (late, 2))
    ]
    alone = [eta_on_vehicle(law, part.motion, part.vehicle, part.ticks) for part in parts]
    whole = [eta_along(law, part.motion)[part.ticks, part.vehicle] for part in parts]
    found = FlownRows(parts).eta(law)
    np.testing.assert_allclose(found, np.concatenate(alone), rtol=0.0, atol=1e-10)  # rounded times
    np.testing.assert_array_equal(np.concatenate(alone), np.concatenate(whole))
    assert np.abs(alone[0]).max() > 0.05


def test_the_fit_finds_the_terms_that_pushes_were_made_with():
    motion = flight()
    push = eta_along(LOADED, motion)[..., 2]
    motion.pos[-400:, :, 0] += [0.0, 2.0, 4.0]  # the end in clear air, for the median
    push[-400:] = 0.0
    good = np.ones(push.shape, dtype=bool)
    samples = push_samples(PushRecord("stack", ("low", "middle", "top"), motion, push, good, ~good))
    jet = fit_to_pushes(samples, JetForm(loaded=True)).jet
    found = [jet.velocity_share, jet.loading, jet.absorption]
    assert found == pytest.approx([0.6, 0.6, 1.5], rel=0.05)  # to the tolerance of the search


def test_pairs_alone_fit_no_loading_which_without_absorption_is_wrong_between_two():
    pair, stack = (free_names(JetForm(loaded=True), stacked=stacked) for stacked in (False, True))
    assert "velocity_share" in pair
    assert not {"loading", "absorption"} & set(pair)
    assert {"loading", "absorption"} <= set(stack)
