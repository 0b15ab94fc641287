"""Controllers of users' classes: lookup by name, and the failsafe while one fails."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from guarded_flights import HOVER, LAND, LEVEL, OK, TICK, guarded, setpoint_at, state_at

from q2q_control.own_controller.checked_controller import CheckedController, ControllerOutputError
from q2q_control.own_controller.find_controller import ControllerClassError, find_controller
from q2q_control.own_controller.level_on_error import LevelOnError
from q2q_control.own_controller.pd_example import PdExample
from q2q_control.own_controller.sensing_example import SensingExample
from q2q_model.signals.values import Interference, SwarmCommand, SwarmImu, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

EXAMPLE = "q2q_control.own_controller.pd_example"
SOURCE = """
class NoReset:
    def __init__(self, vehicle): pass
    def update(self, state, setpoint, interference): pass
class InReset:
    def __init__(self, vehicle): self.ready = False
    def reset(self): self.ready = True
    def update(self, state, setpoint, interference): return {True: "reset"}[self.ready]
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


def test_a_found_class_is_reset_before_its_first_update(module: str) -> None:
    found = find_controller(f"{module}:InReset", CRAZYFLIE_2_0)
    with pytest.raises(ControllerOutputError, match="update returned a str"):  # not KeyError
        found.update(state_at(0.0), setpoint_at(0.0), None)


def test_a_module_that_cannot_be_imported_is_named() -> None:
    with pytest.raises(
        ControllerClassError, match=r"absent_module cannot be imported .*PYTHONPATH is not searched"
    ):
        find_controller("absent_module:Class", CRAZYFLIE_2_0)


@pytest.mark.parametrize("name", ["module", ":Class", "module:", "a/b.py:Class"])
def test_a_name_of_another_form_is_refused(name: str) -> None:
    with pytest.raises(
        ControllerClassError, match=f"^controller {name}: is no name of a class: give module:"
    ):
        find_controller(name, CRAZYFLIE_2_0)


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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t": None}, "t is None; must be that of the setpoint, 0.0 s$"),
        ({"t": np.zeros(2)}, "t is array.*; must be that of the setpoint"),
        ({"names": ("cf1", None)}, "names are .'cf1', None.; must be"),
    ],
)
def test_a_tick_of_another_type_is_an_error_of_the_controller(
    change: dict[str, object], message: str
) -> None:
    class Changed(PdExample):
        def update(
            self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
        ) -> SwarmCommand:
            return replace(super().update(state, setpoint, interference), **change)  # type: ignore[arg-type]

    own = LevelOnError(CheckedController(Changed(CRAZYFLIE_2_0), CRAZYFLIE_2_0))
    assert (own.update(state_at(0.0), setpoint_at(0.0), None).status == LEVEL).all()
    assert re.search(message, own.error)


class WordlessError(Exception):
    """Error that cannot be printed."""

    def __str__(self) -> str:
        """Fail."""
        raise RuntimeError


@pytest.mark.parametrize(
    ("error", "name"),
    [(SystemExit("no key"), "SystemExit: no key"), (WordlessError(), "WordlessError")],
)
def test_an_exit_and_an_error_without_words_are_errors_of_the_controller(
    error: BaseException, name: str
) -> None:
    class Leaving(PdExample):
        def reset(self) -> None:
            raise error

    with pytest.raises(ControllerOutputError, match=f"reset raised {name}"):
        CheckedController(Leaving(CRAZYFLIE_2_0), CRAZYFLIE_2_0).reset()


class Tensor:
    """Array that refuses to be one of numpy's, as a tensor of torch that requires grad."""

    def __array__(self, *_: object, **__: object) -> None:
        """Fail."""
        raise RuntimeError("use detach()")


def test_a_command_that_fails_to_become_an_array_is_an_error_of_the_controller() -> None:
    class Learned(PdExample):
        def update(
            self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
        ) -> SwarmCommand:
            return replace(super().update(state, setpoint, interference), thrust=Tensor())  # type: ignore[arg-type]

    own = LevelOnError(CheckedController(Learned(CRAZYFLIE_2_0), CRAZYFLIE_2_0))
    assert (own.update(state_at(0.0), setpoint_at(0.0), None).status == LEVEL).all()
    said = (
        r"Learned: thrust is not an array \(RuntimeError: use detach\(\)\); must be floats of shape \(2,\)$"
    )
    assert re.search(said, own.error)


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


class Sensing(PdExample):
    """Controller that adds the vertical specific force of the last tick to its thrust [N]."""

    felt: float = 0.0

    def sense(self, imu: SwarmImu) -> None:
        """Keep the specific force of the first vehicle, or fail."""
        if imu.t > 0.015:
            raise RuntimeError("no bias")
        self.felt = float(imu.specific_force_body[0, 2])

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the command."""
        command = super().update(state, setpoint, interference)
        return replace(command, thrust=command.thrust + 1e-3 * self.felt)


def test_a_class_with_sense_gets_inertial_sensors_and_its_error_ends_the_next_update() -> None:
    controller = CheckedController(Sensing(CRAZYFLIE_2_0), CRAZYFLIE_2_0)
    before = controller.update(state_at(0.0), setpoint_at(0.0), None)
    force = np.array([[0.0, 0.0, 9.0], [0.0, 0.0, 9.8]])
    controller.sense(SwarmImu(0.0, setpoint_at(0.0).names, force, np.zeros((2, 3))))
    after = controller.update(state_at(0.01), setpoint_at(0.01), None)
    np.testing.assert_allclose(after.thrust - before.thrust, 9e-3, rtol=1e-9)
    controller.sense(SwarmImu(0.02, setpoint_at(0.0).names, force, np.zeros((2, 3))))
    with pytest.raises(ControllerOutputError, match="sense raised RuntimeError: no bias"):
        controller.update(state_at(0.03), setpoint_at(0.03), None)
    assert controller.senses
    assert not CheckedController(PdExample(CRAZYFLIE_2_0), CRAZYFLIE_2_0).senses


def test_the_sensing_example_finds_what_the_air_does() -> None:
    """Accelerometers show 1.5 m/s^2 less than the thrust: after five time constants that is compensated."""
    own, vehicle = SensingExample(CRAZYFLIE_2_0), CRAZYFLIE_2_0
    rotors = np.full(2, HOVER)  # thrust after the lag [N]
    for k in range(75):
        command = own.update(state_at(k * TICK), setpoint_at(k * TICK), None)
        rotors += (1.0 - np.exp(-TICK / vehicle.thrust_lag)) * (command.thrust - rotors)
        felt = np.zeros((2, 3))
        felt[:, 2] = rotors / vehicle.mass - [1.5, 0.0]
        own.sense(SwarmImu(k * TICK, command.names, felt, np.zeros((2, 3))))
    np.testing.assert_allclose(command.thrust - HOVER, [1.5 * vehicle.mass, 0.0], rtol=0.02, atol=1e-9)


def test_valid_commands_are_flown_again_after_an_error() -> None:
    failing = Failing(CRAZYFLIE_2_0)
    failing.until = 0.2
    own = LevelOnError(CheckedController(failing, CRAZYFLIE_2_0))
    guard = guarded(own)
    made = [guard.update(state_at(k * TICK), setpoint_at(k * TICK), None) for k in range(30)]
    assert (made[19].status == LEVEL).all()
    assert (made[21].status == OK).all()
    assert not own.error
