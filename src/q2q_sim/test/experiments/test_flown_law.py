"""The law of a recorded flight is read from its commands, and not flown again if it is unstable."""

from dataclasses import replace

import numpy as np
import pytest
from turbulent_passes import DT, LAW, air, passes, recorded_passes

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.experiments.validation.recorded.recorded_law import (
    LOOP,
    ReadFlight,
    RecordedLaw,
    check_stable,
    read_law,
)
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.redrawn_flight import redraw_flight


@pytest.fixture(scope="module")
def flight() -> TrackedFlight:
    """Return a flight in the air of strength 1."""
    return recorded_passes()


def test_the_law_is_read_from_the_commands(flight: TrackedFlight) -> None:
    law = read_law(flight, CRAZYFLIE_2_0).law
    np.testing.assert_allclose(law.k_p, LAW.k_p, rtol=0.02)
    np.testing.assert_allclose(law.k_d, LAW.k_d, rtol=0.02)
    assert law.k_i[2] == pytest.approx(0.6, rel=0.1)
    np.testing.assert_allclose(law.offset, 0.0, atol=0.05)
    assert law.attitude.frequency == pytest.approx(60.0, abs=10.0)


def test_the_offset_of_a_vehicle_balances_its_clear_air(flight: TrackedFlight) -> None:
    heavy = replace(flight, thrust=flight.thrust + 0.01, vel=flight.vel)
    assert read_law(heavy, CRAZYFLIE_2_0).law.k_p[2] == pytest.approx(10.0, rel=0.02)
    biased = replace(flight, ref_acc=flight.ref_acc - np.array([0.0, 0.0, 0.2]))
    np.testing.assert_allclose(read_law(biased, CRAZYFLIE_2_0).law.offset[:, 2], 0.2, atol=0.05)


def test_a_limited_velocity_setpoint_gives_its_acceleration_by_the_command(flight: TrackedFlight) -> None:
    limit = 0.6 * np.abs(flight.ref_vel[:, 0, 2]).max()
    clipped = np.clip(flight.ref_vel, -limit, limit)
    shown = replace(flight, ref_vel=clipped, ref_acc=np.gradient(clipped, DT, axis=0))
    feedback_too = LAW.k_d * (flight.ref_vel - clipped)  # what the limit hides from the law
    whole = read_law(shown, CRAZYFLIE_2_0).flight.ref_acc
    rows = np.abs(clipped[:, 0, 2]) >= limit
    miss = (whole - flight.ref_acc - feedback_too)[rows, 0, 2]
    assert rows.mean() > 0.3
    assert np.sqrt((miss**2).mean()) < 0.05


def test_a_flight_without_commands_is_refused(flight: TrackedFlight) -> None:
    with pytest.raises(ValueError, match=r"0\.0 s with thrust commands, and 0 samples"):
        read_law(replace(flight, thrust=np.full_like(flight.thrust, np.nan)), CRAZYFLIE_2_0)


@pytest.mark.parametrize(
    ("k_d", "k_i", "axis"),
    [((-0.22, -0.22, 5.0), 0.6, "x and y"), ((10.0, 10.0, 0.0), 0.6, "z"), ((10.0, 10.0, 5.0), 51.0, "z")],
)
def test_gains_that_stabilise_no_vehicle_are_not_flown_again(
    k_d: tuple[float, ...], k_i: float, axis: str
) -> None:
    check_stable("sound", LAW, CRAZYFLIE_2_0.thrust_lag, 60.0)
    with pytest.raises(ValueError, match=f"flight shaky cannot .* gains of {axis} .* are unstable"):
        check_stable(
            "shaky", replace(LAW, k_d=np.array(k_d), k_i=np.full(3, k_i)), CRAZYFLIE_2_0.thrust_lag, 60.0
        )


def growth(law: RecordedLaw) -> float:
    """Return how much larger horizontal errors are in the last third of 24 s without downwash than before."""
    plan = passes(24.0)
    flown = redraw_flight(ReadFlight(plan, law), CRAZYFLIE_2_0.mass, air(0.0), [0])
    error = np.abs(flown.pos[0] - plan.ref_pos)[..., :2]
    return float(error[-800:].max() / error[:800].max())


def test_a_law_by_which_vehicles_run_away_is_not_flown_again() -> None:
    """Gains read from bags/table2_1, with its attitude loop of 15 rad/s, and with a quick one."""
    quick = replace(LAW, k_p=np.array([18.7, 18.7, 10.0]), k_d=np.array([8.55, 8.55, 5.0]))
    slow = replace(quick, attitude=replace(LOOP, frequency=15.0))
    assert growth(quick) < 1.0
    check_stable("quick", quick, CRAZYFLIE_2_0.thrust_lag, 24.0)
    assert growth(slow) > np.exp(16.0 / 13.0)  # the ticks of the controller delay it further
    with pytest.raises(ValueError, match=r"gains of x and y .* errors grow e-fold in 13 s of 24 s"):
        check_stable("slow", slow, CRAZYFLIE_2_0.thrust_lag, 24.0)
