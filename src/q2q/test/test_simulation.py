"""`q2q.fly` flies what the closed loop flies, and takes controllers and air models of one's own."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import level_command

import q2q
from q2q_control.pid.pid import Pid
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_sim.air.air_names import AirError
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.closed_loop import FlightOptions
from q2q_sim.loop.closed_loop import fly as fly_closed_loop
from q2q_sim.loop.flight_blocks import pid_params

TABLE6 = replace(q2q.scenario("table6"), duration=1.0)
STACK = {
    "vehicle": "crazyflie_2_0",
    "duration": 0.5,
    "vehicles": {
        "cf1": [{"t": 0.0, "pos": [0.0, 0.0, 1.0]}, {"t": 2.0, "pos": [0.0, 0.0, 1.0]}],
        "cf2": [{"t": 0.0, "pos": [0.0, 0.0, 1.5]}, {"t": 2.0, "pos": [0.0, 0.0, 1.5]}],
    },
}
"""Two vehicles that hover above each other, without downwash."""


class Still:
    """Air without any push."""

    def reset(self, setup: q2q.AirSetup) -> None:
        """Remember the number of vehicles."""
        self.none = np.zeros((setup.count, 3))

    def push(self, _: q2q.Sources) -> q2q.Push:
        """Return no push."""
        return q2q.Push(self.none, self.none)


class Upwards(Still):
    """Air that pushes every vehicle upwards by 1 m/s^2."""

    def push(self, _: q2q.Sources) -> q2q.Push:
        """Return the push."""
        return q2q.Push(self.none + np.array([0.0, 0.0, 1.0]), self.none)


class Motionless:
    """Controller that holds the thrust of hovering."""

    def __init__(self, thrust: float) -> None:
        """Take the thrust [N]."""
        self._thrust = thrust

    def update(self, state: SwarmState, setpoint: SwarmSetpoint, _: Interference | None) -> SwarmCommand:
        """Return the thrust for every vehicle."""
        n, names = len(setpoint.names), setpoint.names
        return level_command(state.t, names, np.full(n, self._thrust))

    def reset(self) -> None:
        """Forget nothing."""


def test_the_flight_is_that_of_the_closed_loop_with_the_scenarios_own_model():
    flight = q2q.fly(TABLE6, controller="mpc", seed=3)
    known = find_model(TABLE6.model).interaction
    expected = fly_closed_loop(TABLE6, FlightOptions(controller="mpc", seed=3, model=known))
    np.testing.assert_array_equal(flight.arrays.true_pos, expected.true_pos)
    np.testing.assert_array_equal(flight.arrays.thrust, expected.thrust)
    assert (flight.facts.controller, flight.facts.model, flight.facts.seed) == ("mpc", "paper_law", "3")


@pytest.mark.parametrize(
    ("aware", "limit", "mode"),
    [(False, True, "ignoring"), (True, True, "aware"), (True, False, "aware_unlimited")],
)
def test_aware_and_limit_choose_the_mode(aware: bool, limit: bool, mode: str):
    assert q2q.fly(STACK, aware=aware, limit=limit).facts.mode == mode


def test_a_controller_of_ones_own_flies_as_the_same_one_chosen_by_name():
    own = Pid(pid_params(TABLE6, limited=True), TABLE6.vehicle)
    by_name, by_object = q2q.fly(TABLE6), q2q.fly(TABLE6, controller=own)
    np.testing.assert_array_equal(by_object.arrays.thrust, by_name.arrays.thrust)
    assert by_object.facts.controller == "Pid"


def test_an_air_of_ones_own_pushes_the_vehicles():
    hover = Motionless(q2q.scenario(STACK).vehicle.hover_thrust)
    still, upwards = (q2q.fly(STACK, controller=hover, air=air) for air in (Still(), Upwards()))
    t = still.arrays.t[:, None]
    np.testing.assert_allclose(still.arrays.true_pos[..., 2], [1.0, 1.5] + 0.0 * t, atol=1e-9)
    # 1 m/s^2 from rest: t^2 / 2; a step of 2 ms may come t 2 ms early or late
    risen = upwards.arrays.true_pos[..., 2] - [1.0, 1.5]
    np.testing.assert_allclose(risen, np.broadcast_to(0.5 * t**2, risen.shape), atol=0.002 * 0.5)
    assert upwards.facts.air == "Upwards"


def test_an_air_object_of_a_room_flies_as_the_rooms_name():
    short = replace(q2q.scenario("table6_room", air="room"), duration=0.3)
    by_name = q2q.fly(short)
    by_object = q2q.fly(replace(short, air=""), air=q2q.load_air("room"))
    np.testing.assert_array_equal(by_object.arrays.true_pos, by_name.arrays.true_pos)


def test_an_air_that_returns_nonsense_is_refused_before_the_flight():
    class Wrong(Still):
        def push(self, _: q2q.Sources) -> q2q.Push:
            return q2q.Push(self.none[:1], self.none)

    with pytest.raises(AirError, match="shape"):
        q2q.fly(STACK, air=Wrong())


def test_a_model_is_taken_by_name_or_as_an_object_and_replaces_the_scenarios_own():
    own, by_name = q2q.fly(STACK), q2q.fly(STACK, model="measured_law")
    by_object = q2q.fly(STACK, model=q2q.load_model("measured_law").interaction)
    np.testing.assert_array_equal(by_name.arrays.eta, by_object.arrays.eta)
    assert by_name.arrays.eta[-1, 0, 2] < -1.0
    assert own.arrays.eta[-1, 0, 2] == 0.0
    assert (own.facts.model, by_name.facts.model, by_object.facts.model) == ("none", "measured_law", "Jet")


def test_a_given_plan_is_flown():
    other = q2q.plan(STACK)
    moved = replace(q2q.scenario(STACK), plan=None)
    np.testing.assert_array_equal(q2q.fly(moved, plan=other).arrays.ref_pos, q2q.fly(moved).arrays.ref_pos)


def test_a_plan_is_flown_by_name_not_by_row():
    own = q2q.plan(STACK)
    turned = replace(own, names=own.names[::-1], trajectories=own.trajectories[::-1])
    expected = q2q.fly(STACK).arrays
    for flight in (q2q.fly(STACK, plan=turned), q2q.fly(replace(q2q.scenario(STACK), plan=turned))):
        np.testing.assert_array_equal(flight.arrays.ref_pos, expected.ref_pos)
        np.testing.assert_array_equal(flight.arrays.thrust, expected.thrust)


def test_a_plan_of_other_vehicles_or_from_elsewhere_is_refused():
    own = q2q.plan(STACK)
    first = replace(own, names=own.names[:1], trajectories=own.trajectories[:1])
    swapped = replace(own, trajectories=own.trajectories[::-1])
    for wrong, message in (
        (first, f"the plan lacks {own.names[1]}: the vehicles of the scenario are {', '.join(own.names)}"),
        (swapped, rf"{own.names[0]} starts .* m from its plan's first point \(maximum 0.1 m\)"),
    ):
        with pytest.raises(ValueError, match=message):
            q2q.fly(STACK, plan=wrong)
        with pytest.raises(ValueError, match=message):
            q2q.fly(replace(q2q.scenario(STACK), plan=wrong))
    with pytest.raises(TypeError, match=r"plan = 3; must be a result of q2q.plan"):
        q2q.fly(STACK, plan=3)


def test_a_correction_of_a_controller_of_ones_own_is_refused():
    with pytest.raises(ValueError, match="pid and mpc"):
        q2q.fly(STACK, controller=Motionless(0.3), correct=True)


def test_an_unknown_controller_is_refused_with_those_that_exist():
    with pytest.raises(ValueError, match="pid, mpc"):
        q2q.fly(STACK, controller="lqr")


@pytest.mark.parametrize("given", [object(), Pid])
def test_what_is_no_controller_is_refused_before_the_flight(given: object):
    with pytest.raises(TypeError, match=r"no controller .*: give pid, mpc, or an object"):
        q2q.fly(TABLE6, controller=given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("idle", "note"),
    [
        (Fault("jump", start=0.1, duration=0.1), r"fault jump: size = 0 has no effect: give a size \[m\]"),
        (Fault("nan", start=0.5), "fault nan at 0.5 s is after the end, 0.5 s"),
    ],
)
def test_a_fault_that_does_nothing_is_a_warning(idle: Fault, note: str):
    struck = replace(q2q.scenario(STACK), faults=(idle, Fault("nan", start=0.1)))
    with pytest.warns(UserWarning, match=f"^{note}$") as given:
        q2q.fly(struck)
    assert len(given) == 1
