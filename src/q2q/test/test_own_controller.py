"""Flights with a controller of one's own: its first command that cannot be flown is reported."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hovering_stack import STACK
from resting_signals import level_command, resting_state

import q2q
from q2q_control.own_controller.checked_controller import CheckedController, ControllerOutputError
from q2q_control.own_controller.pd_example import PdExample
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

HOVER = CRAZYFLIE_2_0.hover_thrust

Change = Callable[[SwarmCommand], object]


class Changed:
    """Controller that hovers until 0.05 s and then changes its command."""

    def __init__(self, change: Change, since: float = 0.05) -> None:
        """Take the change and the time of the first changed command [s]."""
        self._change, self._since = change, since

    def update(self, state: SwarmState, setpoint: SwarmSetpoint, _: Interference | None) -> SwarmCommand:
        """Return the command."""
        level = np.zeros(len(setpoint.names))
        command = level_command(state.t, setpoint.names, level + HOVER)
        return command if state.t < self._since - 1e-9 else self._change(command)  # type: ignore[return-value]

    def reset(self) -> None:
        """Forget nothing."""


def with_cf2(what: str, value: float) -> Change:
    """Return the change of a value of the second vehicle's command."""
    return lambda one: replace(one, **{what: np.array([getattr(one, what)[0], value])})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (with_cf2("thrust", np.nan), r"thrust of cf2 at 0.050 s is nan; must be finite and at most 4.8 N in"),
        (with_cf2("thrust", 34.0), r"thrust of cf2 at 0.050 s is 34; must be .* at most 4.8 N in"),  # grams
        (
            with_cf2("thrust", -9.81),
            r"thrust of cf2 at 0.050 s is -9.81; must be .* at most 4.8 N in",
        ),  # m/s^2
        (with_cf2("roll", 10.0), r"roll of cf2 at 0.050 s is 10; must be .* at most 3.14 rad in"),  # degrees
        (
            with_cf2("pitch", np.inf),
            r"pitch of cf2 at 0.050 s is inf; must be finite and at most 3.14 rad in magnitude$",
        ),
        (
            with_cf2("yaw_rate", 200.0),
            r"yaw_rate of cf2 at 0.050 s is 200; must be finite and at most 35 rad/s in magnitude$",
        ),
        (with_cf2("status", 9), r"status is \[0 9\]; must be a CommandStatus, 0 to 6$"),
        (
            lambda one: replace(one, thrust=HOVER),
            r"thrust is float64 of shape \(\); must be floats of shape \(2,\)",
        ),
        (
            lambda one: replace(one, roll=np.zeros((2, 1))),
            r"roll is float64 of shape \(2, 1\); must be floats of",
        ),
        (
            lambda one: replace(one, pitch=["up", "up"]),
            r"pitch is <U2 of shape \(2,\); must be floats of shape",
        ),
        (
            lambda one: replace(one, names=("cf1", "cf1")),
            r"names are \('cf1', 'cf1'\); must be \('cf1', 'cf2'\), in",
        ),
        (lambda one: replace(one, t=3.0), r"t is 3.0; must be that of the setpoint, 0.05 s$"),
        (lambda one: one.thrust, r"update returned a ndarray: return a SwarmCommand$"),
    ],
)
def test_a_command_that_cannot_be_flown_ends_the_flight_with_one_sentence(change: Change, message: str):
    with pytest.raises(ControllerOutputError, match=rf"^controller .*:Changed: {message}") as said:
        q2q.fly(STACK, controller=Changed(change))
    assert "\n" not in str(said.value)


def test_lists_and_whole_numbers_are_numbers():
    exact = q2q.fly(STACK, controller=Changed(lambda one: one))
    loose = q2q.fly(
        STACK,
        controller=Changed(lambda one: replace(one, thrust=one.thrust.tolist(), roll=[0, 0], status=[0, 0])),
    )
    np.testing.assert_array_equal(loose.arrays.true_pos, exact.arrays.true_pos)
    np.testing.assert_array_equal(loose.arrays.thrust, np.full((10, 2), HOVER))


def test_rows_may_be_in_another_order_and_thrust_beyond_the_motors():
    def turned(one: SwarmCommand) -> SwarmCommand:
        return replace(one, names=one.names[::-1], thrust=np.array([4.7, HOVER]))

    flight = q2q.fly(STACK, controller=Changed(turned, since=0.0))
    np.testing.assert_array_equal(flight.arrays.thrust[-1], [HOVER, 4.7])


def test_a_vehicle_without_a_state_may_get_no_number_and_no_other():
    names, level = ("cf1", "cf2"), np.zeros((2, 3))
    pos = np.array([[0.0, 0.0, 1.0], [np.nan, np.nan, np.nan]])
    state = resting_state(0.0, names, pos, status=np.array([0, 2], dtype=np.uint8))
    setpoint = SwarmSetpoint(0.0, names, level, level, level, *np.zeros((2, 2)), np.zeros(2, dtype=np.uint8))
    missing = CheckedController(Changed(with_cf2("thrust", np.nan), since=0.0), CRAZYFLIE_2_0)
    np.testing.assert_array_equal(missing.update(state, setpoint, None).thrust, [HOVER, np.nan])
    with pytest.raises(ControllerOutputError, match="thrust of cf2"):
        missing.update(replace(state, pos=level), setpoint, None)


class Integrating:
    """PI law of the height, which flies `higher` [m], asked for by changing the setpoint it is given."""

    def __init__(self, higher: float = 0.0) -> None:
        """Begin with an empty integral."""
        self._higher, self._sum = higher, 0.0

    def update(self, state: SwarmState, setpoint: SwarmSetpoint, _: Interference | None) -> SwarmCommand:
        """Return the command."""
        goal = setpoint.pos
        goal[:, 2] += self._higher
        error = goal[:, 2] - state.pos[:, 2]
        self._sum = self._sum + 0.01 * np.nan_to_num(error)
        acc = 10.0 * error - 5.0 * state.vel[:, 2] + 5.0 * self._sum
        thrust = CRAZYFLIE_2_0.mass * np.clip(9.81 + acc, 4.0, 14.0)
        return level_command(setpoint.t, setpoint.names, thrust)

    def reset(self) -> None:
        """Empty the integral."""
        self._sum = 0.0


def test_one_controller_flies_the_same_flight_twice() -> None:
    own = Integrating()
    first, again = (q2q.fly(STACK, controller=own).arrays.true_pos for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_arithmetic_in_place_changes_nothing_but_the_command() -> None:
    higher, plain = (q2q.fly(STACK, controller=Integrating(up)).arrays for up in (0.1, 0.0))
    np.testing.assert_array_equal(higher.ref_pos, plain.ref_pos)
    np.testing.assert_array_equal(higher.safe_pos, plain.safe_pos)
    assert (higher.true_pos[-1, :, 2] - plain.true_pos[-1, :, 2] > 1e-3).all()


def test_a_class_by_name_flies_as_its_object() -> None:
    named = q2q.fly(STACK, controller="q2q_control.own_controller.pd_example:PdExample")
    given = q2q.fly(STACK, controller=PdExample(CRAZYFLIE_2_0))
    np.testing.assert_array_equal(named.arrays.true_pos, given.arrays.true_pos)


@pytest.mark.parametrize("controller", ["q2q_control.own_controller.pd_example:PdExample", Integrating()])
def test_options_of_other_controllers_are_refused(controller: str | q2q.Controller) -> None:
    with pytest.raises(ValueError, match=r"correct.* only for pid and mpc"):
        q2q.fly(STACK, controller=controller, correct=True)
    with pytest.raises(ValueError, match=r"limit.* only for pid and mpc"):
        q2q.fly(STACK, controller=controller, limit=False)


def test_a_controller_that_ignores_keeps_the_thrust_limit() -> None:
    with pytest.raises(ValueError, match="limit=False with aware=False: a controller that ignores"):
        q2q.fly(STACK, aware=False, limit=False)
