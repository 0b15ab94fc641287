"""Recorded positions have noise: the delay of a jet is found in spite of it."""

import numpy as np
import pytest

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import PushRecord, push_samples

TICK = 0.01
SLOWNESS = 0.3
"""Of the true jet [s/m]; that of real flights."""
LAW = Jet(
    strength=2.5,
    reference_gap=0.4,
    decay="exponential",
    decay_rate=1.0,
    width=0.05,
    spread=0.05,
    travel_speed=1.0 / SLOWNESS,
    carried=1.0,
    range=1.5,
)


def passes(noise: float) -> PushRecord:
    """Return a minute of a vehicle to and fro over another, with noise of positions [m] and of the push."""
    rng, t = np.random.default_rng(3), TICK * np.arange(6000)
    phase, gap = 2.0 * np.pi * t / 4.0, np.interp(t, [0.0, 30.0, 60.0], [0.25, 0.7, 0.25])
    pos = np.zeros((t.size, 2, 3))
    pos[..., 2] = 1.0
    pos[:, 1] += np.stack([0.6 * np.sin(phase), 0.03 * np.sin(0.8 * phase), gap], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (t.size, 2, 1))
    true = Motion(t, pos, np.gradient(pos, TICK, axis=0), up)
    push = eta_along(LAW, true)[..., 2] + 0.3 * rng.standard_normal((t.size, 2))
    seen = Motion(t, pos + noise * rng.standard_normal(pos.shape), true.vel, up)
    good = np.ones((t.size, 2), dtype=np.bool_)
    return PushRecord("passes", ("lower", "upper"), seen, push, good, ~good)


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.003])
def test_the_delay_of_a_jet_is_found_in_positions_with_noise(noise: float) -> None:
    """By the derivative over a tick, 3 mm give 0.171 [0.163, 0.179] from a start at 0.15."""
    found = dict(fit_to_pushes(push_samples(passes(noise)), JetForm()).intervals)["slowness"]
    assert found.low < SLOWNESS < found.high, found
    assert found.value == pytest.approx(SLOWNESS, abs=0.02)
