"""Flights with an interaction model of one's own: flown as it is, and reported at its first wrong output."""

from dataclasses import replace

import numpy as np
import pytest
from hovering_stack import STACK

import q2q
from q2q.checked_model import PLACES, CheckedModel
from q2q_model.downwash.interaction_model import ModelOutputError, PairMotion, Reach, pairs_at_rest
from q2q_model.downwash.jet import Jet
from q2q_model.signals.values import Array


class Steady:
    """Model that pushes every vehicle in reach down by 1 m/s^2."""

    reach = Reach(horizontal=0.5, vertical=2.0)
    max_delay = 0.0

    def delay(self, rel_pos: Array) -> Array:
        """Return no delay."""
        return np.zeros(rel_pos.shape[:-1])

    def acceleration(self, rel_pos: Array, _: PairMotion) -> Array:
        """Return the push."""
        return np.zeros(rel_pos.shape) + np.array([0.0, 0.0, -1.0])

    def deviation(self, rel_pos: Array, _: PairMotion) -> Array:
        """Return that it is unknown."""
        return np.full(rel_pos.shape, np.nan)


class NotANumber(Steady):
    """Model that fails half a metre below a source, where no trial asks."""

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the push."""
        below = (rel_pos[..., 2:] > 0.45) & (rel_pos[..., 2:] < 0.55)
        return np.where(below, np.nan, super().acceleration(rel_pos, motion))


class Hurricane(Steady):
    """Model whose push is none of an air."""

    def acceleration(self, rel_pos: Array, _: PairMotion) -> Array:
        """Return the push."""
        return np.full(rel_pos.shape, 1e4)


class Scalar(Steady):
    """Model without axes of pairs."""

    def acceleration(self, _: Array, __: PairMotion) -> Array:
        """Return the push."""
        return np.array([0.0, 0.0, -1.0])


class NoBatch(Steady):
    """Model that knows one axis of pairs only, not those of an MPC's horizon."""

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the push."""
        return super().acceleration(rel_pos.reshape(-1, 3), motion)


class Early(Steady):
    """Model whose air arrives before it left."""

    def delay(self, rel_pos: Array) -> Array:
        """Return the delay."""
        return np.full(rel_pos.shape[:-1], -0.1)


class Late(Steady):
    """Model whose air takes 0.2 s a metre, everywhere, and whose largest delay is that of `longest` [m]."""

    def __init__(self, longest: float) -> None:
        self.max_delay = 0.2 * longest

    def delay(self, rel_pos: Array) -> Array:
        """Return the delay."""
        return 0.2 * np.abs(rel_pos[..., 2])


class Doubtful(Steady):
    """Model with a negative deviation."""

    def deviation(self, rel_pos: Array, _: PairMotion) -> Array:
        """Return the deviation."""
        return np.full(rel_pos.shape, -1.0)


class Boundless(Steady):
    """Model whose reach is no Reach."""

    reach = (0.5, 2.0)  # type: ignore[assignment]


class Timeless(Steady):
    """Model without a largest delay."""

    max_delay = np.nan


@pytest.mark.parametrize("controller", ["pid", "mpc"])
def test_a_model_of_ones_own_flies_with_its_own_numbers(controller: str):
    flight = q2q.fly(STACK, model=Steady(), controller=controller)
    eta = flight.arrays.eta
    np.testing.assert_array_equal(eta, np.broadcast_to([0.0, 0.0, -1.0], eta.shape))
    assert flight.facts.model == "Steady"


def test_a_checked_model_returns_what_its_model_does():
    jet, rel_pos = Jet(travel_speed=5.0), np.array([[0.1, 0.0, 0.5], [0.0, 0.2, -0.5]])
    motion = PairMotion(np.full((2, 3), 0.1), np.tile([0.0, 0.0, 1.0], (2, 1)), np.zeros((2, 3)))
    checked = CheckedModel(jet)
    np.testing.assert_array_equal(checked.acceleration(rel_pos, motion), jet.acceleration(rel_pos, motion))
    np.testing.assert_array_equal(checked.deviation(rel_pos, motion), jet.deviation(rel_pos, motion))
    np.testing.assert_array_equal(checked.delay(rel_pos), jet.delay(rel_pos))
    assert (checked.reach, checked.max_delay) == (jet.reach, jet.max_delay)


@pytest.mark.parametrize("controller", ["pid", "mpc"])
def test_a_wrong_output_in_flight_names_the_vehicles_and_what_is_allowed(controller: str):
    message = (
        r"^cf1 in the downwash of cf2 at 0.000 s: model .*:NotANumber: acceleration for a source at rel_pos "
        r"\[0\. +0\. +0\.5\] m is \[nan nan nan\]; must be finite and at most 1000 m/s\^2 in magnitude$"
    )
    with pytest.raises(ModelOutputError, match=message):
        q2q.fly(STACK, model=NotANumber(), controller=controller)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (Hurricane(), r"acceleration for .* is \[10000. .*; must be finite and at most 1000 m/s\^2 in"),
        (Scalar(), r"acceleration is float64 of shape \(3,\); must be floats of shape \(12, 3\)$"),
        (NoBatch(), r"acceleration is float64 of shape \(24, 3\); must be floats of shape \(2, 12, 3\)$"),
        (Early(), r"delay for .* is \[-0.1\]; must be finite and at least 0 s$"),
        (Late(0.5), r"delay for .* -1. *\] m is \[0.2\]; must be at most max_delay = 0.1 s within reach$"),
        (Late(0.0), r"delay for .* -1. *\] m is \[0.2\]; must be at most max_delay = 0 s within reach$"),
        (Doubtful(), r"deviation for .* is \[-1. -1. -1.\]; must be in \[0, 1000\] m/s\^2, or NaN where"),
        (Boundless(), r"reach is \(0.5, 2.0\); must be a Reach of finite distances \[m\]$"),
        (Timeless(), r"max_delay is nan; must be a finite time \[s\]$"),
    ],
)
def test_a_model_that_cannot_be_flown_with_is_refused_before_the_flight(model: Steady, message: str):
    with pytest.raises(ModelOutputError, match=message):
        q2q.fly(STACK, model=model)
    with pytest.raises(ModelOutputError, match=message):
        q2q.plan(STACK, around=replace(q2q.load_model("none"), interaction=model))


def test_a_delay_up_to_the_longest_within_reach_is_that_of_the_model() -> None:
    """Beyond reach, 2 m of height, there is no downwash: how long its air would take does not matter."""
    at = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, -1.9], [0.0, 0.0, 3.0], [0.6, 0.0, 5.0]])
    np.testing.assert_array_equal(CheckedModel(Late(2.0)).delay(at), 0.2 * np.abs(at[:, 2]))


@pytest.mark.parametrize("given", [3, None, Steady, lambda rel_pos, _: rel_pos])
def test_what_is_no_model_is_refused(given: object):
    for choose in (q2q.load_model, lambda one: q2q.plan(STACK, around=q2q.ModelFile(one))):
        with pytest.raises(TypeError, match=r"^no model .*: give a name, the path of a .q2q file, a"):
            choose(given)  # type: ignore[arg-type]


def test_an_output_for_a_pair_whose_place_is_unknown_is_not_judged():
    class Follows(Steady):
        def acceleration(self, rel_pos: Array, _: PairMotion) -> Array:
            return 0.0 * rel_pos

    lost = np.array([[np.nan, 0.0, 0.5]])
    motion = PairMotion(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3)))
    assert np.isnan(CheckedModel(Follows()).acceleration(lost, motion)[0, 0])


class InPlace(Steady):
    """Model that takes the magnitude of what it is given, in place."""

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the push."""
        np.abs(rel_pos, out=rel_pos)
        np.abs(motion.vel, out=motion.vel)
        return super().acceleration(rel_pos, motion)


def test_a_model_that_computes_in_place_changes_no_argument() -> None:
    rel_pos, vel = np.array([[0.1, 0.0, -0.5]]), np.array([[0.0, -1.0, 0.0]])
    model = CheckedModel(InPlace())
    assert (CheckedModel(Steady()).acceleration(PLACES, pairs_at_rest(PLACES))[:, 2] == -1.0).all()
    model.acceleration(rel_pos, PairMotion(source_vel=vel, source_axis=vel, vel=vel))
    np.testing.assert_array_equal(rel_pos, [[0.1, 0.0, -0.5]])
    np.testing.assert_array_equal(vel, [[0.0, -1.0, 0.0]])
    assert (PLACES[:, 2] < 0.0).sum() == 6
