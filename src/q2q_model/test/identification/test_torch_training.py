"""The paper's training in torch agrees with the exact loss."""

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.networks.fit import adam, random_weights
from q2q_model.identification.networks.gradient import pack, unpack
from q2q_model.identification.networks.trajectory_loss import flight_terms, trajectory_loss
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

training = pytest.importorskip(
    "q2q_model.identification.networks.torch_training",
    reason="torch is not installed: requirements/train.txt",
)
REACH = (0.6, 6.6)
RNG = np.random.default_rng(1)
MODEL = unpack(random_weights(RNG) + 0.03 * RNG.standard_normal(322), 0.1, 1.1)


def record() -> AltitudeRecord:
    """Return a short pass."""
    return altitude_record(made_flight(Pass(speed=1.0, seconds=6.0)), CRAZYFLIE_2_0)


@pytest.mark.parametrize("lag", [0.0, 0.1])
def test_an_adaptive_solver_and_the_fixed_point_find_the_same_loss_and_gradient(lag: float):
    loop = AltitudeLoop(k_p=0.81, k_d=0.43, lag=lag)
    exact = trajectory_loss(MODEL, [flight_terms(record(), loop, REACH)])
    loss, gradient = training.loss_and_gradient([record()], loop, MODEL)
    assert loss == pytest.approx(exact.loss, rel=2e-3)  # the solver's tolerance, 1e-5 a step
    off = np.linalg.norm(gradient.numpy() - exact.gradient) / np.linalg.norm(exact.gradient)
    assert off < 5e-3


def test_both_ways_of_adam_walk_the_same_path():
    loop = AltitudeLoop(k_p=0.81, k_d=0.43)
    ours, reference = (
        adam([flight_terms(record(), loop, REACH)], MODEL),
        training.train([record()], loop, MODEL),
    )
    for _ in range(3):
        model, loss = next(ours)
        theta, its_loss = next(reference)
    assert its_loss == pytest.approx(loss, rel=2e-3)
    np.testing.assert_allclose(theta.numpy(), pack(model), atol=1e-4)  # of three steps of 1e-4 each
    assert np.corrcoef(theta.numpy() - pack(MODEL), pack(model) - pack(MODEL))[0, 1] > 0.99
