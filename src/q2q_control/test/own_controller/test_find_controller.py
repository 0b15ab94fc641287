"""Controllers of users' classes: lookup by name, and the failsafe while one fails."""

from pathlib import Path

import numpy as np
import pytest
from guarded_flights import HOVER, LAND, LEVEL, OK, TICK, guarded, setpoint_at, state_at

from q2q_control.own_controller.checked_controller import CheckedController, ControllerOutputError
from q2q_control.own_controller.find_controller import ControllerClassError, find_controller
from q2q_control.own_controller.level_on_error import LevelOnError
from q2q_control.own_controller.pd_example import PdExample
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

EXAMPLE = "q2q_control.own_controller.pd_example"
SOURCE = """
class NoReset:
    def __init__(self, vehicle): pass
    def update(self, state, setpoint, interference): pass
class Raises:
    def __init__(self, vehicle): raise RuntimeError("no gains")
number = 3
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "written_controllers.py").write_text(SOURCE)
    monkeypatch.chdir(tmp_path)
    return "written_controllers"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("NoReset", r"the class needs methods update\(state, setpoint, interference\) and reset\(\)$"),
        ("Raises", r"Raises\(vehicle\) raised RuntimeError: no gains$"),
        ("number", "written_controllers has no class number$"),
        ("Absent", "written_controllers has no class Absent$"),
    ],
)
def test_a_class_that_is_no_controller_is_refused_by_name(module: str, name: str, message: str) -> None:
    with pytest.raises(ControllerClassError, match=f"^controller {module}:{name}: {message}"):
        find_controller(f"{module}:{name}", CRAZYFLIE_2_0)


def test_a_module_that_cannot_be_imported_is_named() -> None:
    with pytest.raises(ControllerClassError, match="absent_module cannot be imported"):
        find_controller("absent_module:Class", CRAZYFLIE_2_0)


def test_a_found_class_commands_as_its_object() -> None:
    found = find_controller(f"{EXAMPLE}:PdExample", CRAZYFLIE_2_0)
    state, setpoint = state_at(0.0), setpoint_at(0.0)
    felt = Interference(
        0.0,
        setpoint.names[::-1],
        np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]),
        np.zeros((2, 3)),
        np.zeros(2, dtype=np.uint8),
    )
    made, alone = found.update(state, setpoint, felt), PdExample(CRAZYFLIE_2_0).update(state, setpoint, felt)
    np.testing.assert_array_equal(made.thrust, alone.thrust)
    np.testing.assert_allclose(made.thrust, [HOVER, HOVER + CRAZYFLIE_2_0.mass * 1.0], rtol=1e-12)
    np.testing.assert_allclose(made.pitch, [10.0 * 0.1 / 9.81, 0.0], rtol=1e-12)  # 0.1 m short of x


class Failing(PdExample):
    """Controller that fails for some time."""

    since, until = 0.1, np.inf

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the command, or raise KeyError."""
        if self.since <= setpoint.t < self.until:
            raise KeyError("mode")
        return super().update(state, setpoint, interference)


def test_an_error_of_the_class_names_file_and_line() -> None:
    controller = CheckedController(Failing(CRAZYFLIE_2_0), CRAZYFLIE_2_0)
    with pytest.raises(ControllerOutputError, match=r"raised KeyError: 'mode' \(test_find_co.*, line \d+"):
        controller.update(state_at(0.2), setpoint_at(0.2), None)


def test_while_it_fails_vehicles_are_levelled_and_then_landed() -> None:
    own = LevelOnError(CheckedController(Failing(CRAZYFLIE_2_0), CRAZYFLIE_2_0))
    guard = guarded(own)
    made = [guard.update(state_at(k * TICK), setpoint_at(k * TICK), None) for k in range(130)]
    assert (made[9].status == OK).all()
    assert (made[10].status == LEVEL).all()
    assert (made[105].status == LEVEL).all()
    assert (made[115].status == LAND).all()
    np.testing.assert_allclose(made[10].thrust, HOVER, rtol=0.02)
    assert "KeyError" in own.error


def test_valid_commands_are_flown_again_after_an_error() -> None:
    failing = Failing(CRAZYFLIE_2_0)
    failing.until = 0.2
    own = LevelOnError(CheckedController(failing, CRAZYFLIE_2_0))
    guard = guarded(own)
    made = [guard.update(state_at(k * TICK), setpoint_at(k * TICK), None) for k in range(30)]
    assert (made[19].status == LEVEL).all()
    assert (made[21].status == OK).all()
    assert not own.error
