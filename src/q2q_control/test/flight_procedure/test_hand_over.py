"""A controller is reset where its commands begin to be flown."""

from collections.abc import Callable

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_control.controller import Controller
from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.flight_procedure.hand_over import HandOver, HandOvers
from q2q_control.flight_procedure.steps import Step
from q2q_control.mpc.mpc import Mpc
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.pid.gains_file import load_gains
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_1

HOVER = CRAZYFLIE_2_1.hover_thrust
CONTROLLERS: dict[str, Callable[[], Controller]] = {
    "pid": lambda: Pid(load_gains("tuned"), CRAZYFLIE_2_1),
    "observed": lambda: ObservedPid(load_gains("tuned"), TrackerParams(), CRAZYFLIE_2_1),
    "mpc": lambda: Mpc(MpcParams(), CRAZYFLIE_2_1, NoInteraction()),
}
BEGINS = [
    ([Step.CHECKED, Step.ARMING, Step.TAKE_OFF, Step.HOVER, Step.TRANSIT, Step.FLIGHT], Step.TRANSIT),
    ([Step.CHECKED, Step.ARMING, Step.FLIGHT], Step.FLIGHT),
    ([Step.HOLD, Step.TRANSIT, Step.FLIGHT, Step.HOLD], None),
    ([Step.FLIGHT, Step.LANDING, Step.HOLD], None),
    ([Step.FLIGHT, Step.LANDING, Step.DISARMING, Step.CONNECTED], None),
]


def at_rest(t: float, height: float, climb: float, beside: float) -> tuple[SwarmState, SwarmSetpoint]:
    """Return the tick of a vehicle whose setpoint is `beside` it [m]."""
    pos = np.array([[0.0, 0.0, height]])
    vel = np.array([[0.0, 0.0, climb]])
    state = resting_state(t, ("cf1",), pos, vel=vel)
    return state, resting_setpoint(t, ("cf1",), pos + np.array([beside, 0.0, 0.0]))


def climbed(guard: Guard) -> float:
    """Let a vehicle stand beside its setpoint, then climb on board in 2 s; return the time [s]."""
    for k in range(1000):
        guard.update(*at_rest(0.01 * k, 0.0, 0.0, 0.1), None)
    for k in range(200):
        s = 0.005 * k
        height = 0.5 * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        climb = 0.25 * s * s * (30.0 - 60.0 * s + 30.0 * s * s)
        guard.update(*at_rest(10.0 + 0.01 * k, height, climb, 0.0), None)
    return 12.0


def after(guard: Guard, t: float) -> SwarmCommand:
    """Return the fifth command from time t [s] on, of a vehicle at rest at its setpoint."""
    return [guard.update(*at_rest(t + 0.01 * k, 0.5, 0.0, 0.0), None) for k in range(5)][-1]


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_vehicle_hovers_from_the_hand_over_on(name: str) -> None:
    """Observers had learned 3 m/s^2 in the climb, integrals 2 m/s^2 in a minute beside the setpoint."""
    guard = Guard(CONTROLLERS[name](), FallbackParams(), HOVER)
    t = climbed(guard)
    guard.begin_flight()
    command = after(guard, t)
    assert command.thrust[0] == pytest.approx(HOVER, rel=1e-3)  # the MPC's solution is that exact
    np.testing.assert_allclose((command.roll[0], command.pitch[0]), 0.0, atol=1e-6)


def test_motors_that_were_cut_stay_cut() -> None:
    guard = Guard(CONTROLLERS["pid"](), FallbackParams(), HOVER)
    t = climbed(guard)
    guard.cut_all()
    guard.begin_flight()
    assert after(guard, t).status[0] == CommandStatus.CUT


@pytest.mark.parametrize(("steps", "begins"), BEGINS)
def test_commands_begin_to_be_flown_once_a_flight(steps: list[Step], begins: Step | None) -> None:
    hand_over = HandOver()
    assert [step for step in steps if hand_over.update(step.value)] == ([] if begins is None else [begins])


def test_the_step_of_older_bags_to_the_first_points_is_a_transit() -> None:
    hand_over = HandOver()
    assert not hand_over.update(Step.CHECKED.value)
    assert hand_over.update("glide")
    assert hand_over.flying


def test_a_controller_that_is_started_in_flight_has_nothing_to_forget() -> None:
    assert not HandOver().update(Step.FLIGHT.value)


def test_a_controller_that_flies_vehicles_of_one_procedure_does_not_start_anew_for_another() -> None:
    hand_overs = HandOvers()
    taken = [
        hand_overs.update(name, step.value)
        for name, step in (
            ("a", Step.CHECKED), ("b", Step.CHECKED), ("a", Step.TRANSIT),
            ("b", Step.HOVER), ("b", Step.TRANSIT), ("b", Step.LANDING), ("b", Step.CONNECTED),
            ("a", Step.LANDING), ("a", Step.CONNECTED), ("b", Step.FLIGHT),
        )
    ]  # fmt: skip
    assert taken == [False, False, True, *[False] * 6, True]


def test_a_procedure_whose_node_has_gone_flies_no_vehicle() -> None:
    hand_overs = HandOvers()
    hand_overs.update("a", Step.FLIGHT.value)
    begins, flying = [], []
    for step, publishing in ((Step.CHECKED, {"a", "b"}), (Step.TRANSIT, {"a", "b"}), (Step.CHECKED, {"b"}),
                             (Step.TRANSIT, {"b"})):  # fmt: skip
        hand_overs.end_absent(publishing)
        begins.append(hand_overs.update("b", step.value))
        flying.append(hand_overs.flying)
    assert begins == [False, False, False, True]
    assert flying == [True, True, False, True]


@pytest.mark.parametrize(
    ("back", "begins"), [([Step.FLIGHT], [False]), ([Step.CHECKED, Step.TRANSIT], [False, True])]
)
def test_a_procedure_that_is_back_begins_a_flight_from_the_ground_only(
    back: list[Step], begins: list[bool]
) -> None:
    hand_overs = HandOvers()
    hand_overs.update("a", Step.FLIGHT.value)
    hand_overs.end_absent({"a"})
    hand_overs.end_absent(set())
    assert [hand_overs.update("a", step.value) for step in back] == begins
    assert hand_overs.flying


def test_a_procedure_of_a_bag_that_another_node_plays_goes_on_to_fly() -> None:
    hand_overs = HandOvers()
    hand_overs.update("a", Step.FLIGHT.value)
    hand_overs.end_absent({"bag_play"})
    assert hand_overs.flying
    assert not hand_overs.update("b", Step.TRANSIT.value)


def test_vehicles_fly_while_those_of_any_procedure_do() -> None:
    hand_overs = HandOvers()
    flying = [hand_overs.flying]
    for name, step in (
        ("a", Step.CHECKED), ("a", Step.FLIGHT), ("b", Step.CHECKED), ("a", Step.LANDING), ("b", Step.HOVER),
    ):  # fmt: skip
        hand_overs.update(name, step.value)
        flying.append(hand_overs.flying)
    assert flying == [True, False, True, True, False, True]
