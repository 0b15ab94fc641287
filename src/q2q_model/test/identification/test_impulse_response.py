"""The response of the altitude loop to its start, its reference and a downwash."""

import numpy as np
import pytest
from made_flights import PLAIN
from scipy.integrate import solve_ivp

from q2q_model.identification.gains.impulse_response import downwash_response, free_response, impulse_response
from q2q_model.vehicle.altitude_loop import AltitudeLoop

RICH = AltitudeLoop(k_p=0.81, k_d=0.43, k_i=0.1, offset=0.2, lag=0.1)


@pytest.mark.parametrize("loop", [PLAIN, RICH])
def test_the_loops_exact_response_is_that_of_an_accurate_solver(loop: AltitudeLoop) -> None:
    dt, ticks = 0.01, 800
    t = np.arange(ticks) * dt
    eta = np.interp(t, [3.0, 4.0, 5.0], [0.0, -1.0, 0.0], left=0.0, right=0.0)
    start = np.array([[0.1], [-0.05]])

    def rate(when: float, x: np.ndarray) -> list[float]:
        demanded = -loop.k_p * x[0] - loop.k_d * x[1] + loop.k_i * x[2] + loop.offset
        downwash = np.interp(when, t, eta)
        commanded_acc = x[3] if loop.lag else demanded
        return [x[1], commanded_acc + downwash, -x[0], (demanded - x[3]) / loop.lag if loop.lag else 0.0]

    settled = loop.offset - loop.k_p * 0.1 + loop.k_d * 0.05
    exact = {"rtol": 1e-9, "atol": 1e-11, "max_step": 0.05}
    solved = solve_ivp(rate, (0.0, t[-1]), [0.1, -0.05, 0.0, settled], t_eval=t, **exact)
    found = free_response(loop, dt, start, np.zeros((ticks, 1))) + downwash_response(loop, dt, eta[:, None])
    np.testing.assert_allclose(found[:, 0], solved.y[0], atol=1e-7)  # the solver's own error


def test_the_response_to_any_downwash_is_its_convolution_with_the_impulse_response() -> None:
    eta = np.random.default_rng(12).standard_normal((300, 2))
    eta[0] = 0.0
    h = impulse_response(RICH, 0.01, 300)
    expected = np.stack([np.convolve(h, eta[:, k])[:300] for k in range(2)], axis=1)
    np.testing.assert_allclose(downwash_response(RICH, 0.01, eta), expected, atol=1e-12)


def test_a_vehicle_that_starts_beside_its_moving_reference_catches_up_without_knowing_its_jerk() -> None:
    """With lag the reference's jerk drives the error: a steady jerk j leaves -T j / K_p."""
    ticks = 4000
    loop = AltitudeLoop(k_p=4.0, k_d=4.0, lag=0.05)
    error = free_response(loop, 0.01, np.zeros((2, 1)), np.full((ticks, 1), 0.3))
    assert error[-1, 0] == pytest.approx(-0.05 * 0.3 / 4.0, rel=1e-6)
