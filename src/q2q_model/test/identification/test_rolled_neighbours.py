"""With the neighbours of another time a jet explains nothing of a public flight."""

from dataclasses import replace

import numpy as np
import pytest
from public_flights import OFF, needs_flights, real_samples

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.along_flight import eta_on_vehicle
from q2q_model.identification.push.push_samples import (
    PushSamples,
)
from q2q_model.signals.values import Array


@pytest.fixture(scope="module")
def below() -> list[PushSamples]:
    """Return what the lower vehicles of the flights without feed-forward felt."""
    return [one for found in real_samples(OFF).values() for one in found if one.exposed.any()]


@pytest.fixture(scope="module")
def jet_of_them(below: list[PushSamples]) -> Jet:
    """Return the jet fitted to these very samples."""
    return fit_to_pushes(below, JetForm()).jet


@needs_flights
@pytest.mark.parametrize("seconds", [7.3, 10.0, 13.7, 23.1])
def test_with_a_neighbours_log_rolled_the_gain_vanishes(
    below: list[PushSamples], jet_of_them: Jet, seconds: float
) -> None:
    """The same rows, those exposed to the true neighbour; the law is fed with the neighbour of another time.

    R2 of the scoring rule is not centred: on these rows somebody is above, by about 2 m/s^2 on average, and a
    constant explains 0.60. In half of them the rolled neighbour is above too, for these flights pass and pass
    again, which leaves 0.03 to 0.21 of R2 at any roll. The gain is what a law explains beyond the constant:
    0.75 with the true neighbour, below -0.9 with the rolled one. Over all usable rows R2 itself is negative.
    """
    rolled = [_rolled(one, seconds) for one in below]
    assert _beyond_constant(jet_of_them, below) > 0.7
    assert _beyond_constant(jet_of_them, rolled) < -0.5
    assert _explained(jet_of_them, rolled, "exposed") < 0.3
    assert _explained(jet_of_them, below, "usable") > 0.75
    assert _explained(jet_of_them, rolled, "usable") < -0.4


@needs_flights
@pytest.mark.parametrize("seconds", [7.3, 10.0])
def test_a_law_fitted_to_a_rolled_neighbour_explains_less_than_a_constant(
    below: list[PushSamples], seconds: float
) -> None:
    """Refitted, the jet becomes as wide as it may, a constant for whoever is exposed, and stays below it."""
    rolled = [_rolled(one, seconds) for one in below]
    jet = fit_to_pushes(rolled, JetForm()).jet
    assert jet.width > 0.3  # that of the true neighbour: 0.05
    assert _beyond_constant(jet, rolled) < 0.0
    assert _explained(jet, rolled, "usable") < 0.0


def _explained(jet: Jet, samples: list[PushSamples], rows: str) -> float:
    y, eta = _measured_and_predicted(jet, samples, rows)
    return float(1.0 - ((y - eta) @ (y - eta)) / (y @ y))


def _beyond_constant(jet: Jet, samples: list[PushSamples]) -> float:
    """Return 1 - sum (y - eta)^2 / sum (y - mean y)^2 over exposed rows."""
    y, eta = _measured_and_predicted(jet, samples, "exposed")
    return float(1.0 - ((y - eta) @ (y - eta)) / ((y - y.mean()) @ (y - y.mean())))


def _measured_and_predicted(jet: Jet, samples: list[PushSamples], rows: str) -> tuple[Array, Array]:
    chosen = [np.nonzero({"exposed": one.exposed, "usable": one.usable}[rows])[0] for one in samples]
    eta = [
        eta_on_vehicle(jet, one.motion, one.vehicle, at)[:, 2]
        for one, at in zip(samples, chosen, strict=True)
    ]
    return np.concatenate([one.y[at] for one, at in zip(samples, chosen, strict=True)]), np.concatenate(eta)


def _rolled(one: PushSamples, seconds: float) -> PushSamples:
    """Return the samples with everyone but the vehicle itself so much late; rows stay as they were chosen."""
    motion = one.motion
    pos, vel, axis = (values.copy() for values in (motion.pos, motion.vel, motion.axis))
    others = [j for j in range(pos.shape[1]) if j != one.vehicle]
    for values in (pos, vel, axis):
        values[:, others] = np.roll(values[:, others], round(seconds * 100.0), axis=0)
    return replace(one, motion=replace(motion, pos=pos, vel=vel, axis=axis))
