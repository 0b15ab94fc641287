"""A vehicle whose attitude was never upright, above another: it is not flown, the other flies on."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from guarded_flights import CUT, HOVER, LAND, LEVEL, OK, PARAMS, SATURATED, guarded, mpc, pid
from resting_signals import resting_setpoint

from q2q_control.controller import Controller
from q2q_control.crazyswarm.message_conversion import poses_of
from q2q_control.flight_procedure.flight_view import FlightView
from q2q_control.mpc.mpc import Mpc
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.values import Interference, MocapFrame, Names, SwarmCommand, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

NAMES: Names = ("lower", "upper")
PLACE = np.array([[0.0, 0.0, 1.0], [0.02, 0.0, 1.5]])
DT = 0.01


def aware_mpc() -> Mpc:
    return Mpc(MpcParams(), CRAZYFLIE_2_0, MEASURED_LAW)


def seen(ticks: int, upper: float) -> list[tuple[SwarmState, Interference]]:
    """Return states and downwash of hovering vehicles; `upper` of 1 is upright, of -1 upside down."""
    block, predictor = MocapFilter(MocapFilterParams(), NAMES), InteractionPredictor(MEASURED_LAW)
    quat = identity_quat((2,))
    if upper < 0.0:
        quat[1] = quat[1, [3, 0, 1, 2]]
    states = [block.update(MocapFrame(k * DT, NAMES, PLACE, quat)) for k in range(ticks)]
    return [(state, predictor.update(state)) for state in states]


def commands(
    controller: Controller, flown: Names, ticks: list[tuple[SwarmState, Interference]]
) -> list[SwarmCommand]:
    guard = guarded(controller)
    rows = [NAMES.index(name) for name in flown]
    return [guard.update(state, resting_setpoint(state.t, flown, PLACE[rows]), felt) for state, felt in ticks]


@pytest.mark.parametrize("controller", [pid, aware_mpc], ids=["pid", "mpc"])
def test_below_a_vehicle_that_somebody_else_flies_commands_are_those_below_an_upright_one(
    controller: Callable[[], Controller],
) -> None:
    found, expected = (commands(controller(), ("lower",), seen(60, sign)) for sign in (-1.0, 1.0))
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one.thrust, other.thrust)
        np.testing.assert_array_equal(one.status, other.status)
    assert found[-1].thrust[0] > 1.1 * HOVER  # 2.1 m/s^2 of downwash


def test_an_mpc_of_both_compensates_the_downwash_of_its_own_vehicle_without_attitude() -> None:
    found, expected = (commands(aware_mpc(), NAMES, seen(60, sign)) for sign in (-1.0, 1.0))
    thrust = [np.array([one.thrust[0] for one in made]) for made in (found, expected)]
    # the joint problem lets the upper one give way from where it is seen, not from its last solution
    np.testing.assert_allclose(*thrust, atol=0.02 * HOVER)
    assert thrust[0].min() > 1.1 * HOVER


@pytest.mark.parametrize("controller", [pid, mpc], ids=["pid", "mpc"])
def test_the_vehicle_itself_is_level_then_lands_and_is_cut_and_the_other_flies(
    controller: Callable[[], Controller],
) -> None:
    made = commands(controller(), NAMES, seen(round(PARAMS.cut_after_s / DT) + 10, -1.0))
    status = np.array([one.status for one in made])
    ages = DT * np.arange(len(made)) + 1e-9
    land, cut = ages >= PARAMS.land_after_s, ages >= PARAMS.cut_after_s
    np.testing.assert_array_equal(status[:, 1], np.where(cut, CUT, np.where(land, LAND, LEVEL)))
    assert set(status[:, 0].tolist()) <= {OK, SATURATED}
    assert max(abs(one.thrust[1]) for one in made) <= HOVER


def test_a_vehicle_below_moves_aside_of_one_that_lands_without_attitude() -> None:
    made = commands(pid(), NAMES, seen(100, -1.0))
    np.testing.assert_allclose(made[-1].pitch[1], 0.0, atol=1e-12)
    assert made[-1].pitch[0] < -0.05  # rad: along -x, away from the one at x = 0.02 m


def test_it_does_not_take_off_until_it_is_upright_and_is_sent_no_attitude() -> None:
    view = FlightView(NAMES)
    state = seen(10, -1.0)[-1][0]
    view.store_state(state, 0.0)
    assert view.observe((), 0.0).without_attitude == ("upper",)
    assert np.isnan(poses_of(state)[1].quat).all()
    assert poses_of(state)[1].pos == (0.02, 0.0, 1.5)
    view.store_state(replace(state, quat=identity_quat((2,))), 0.1)
    assert view.observe((), 0.1).without_attitude == ()
