"""Tests of flights in a wake of a user's class: when it is called, its inputs, and refused answers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_names import AirError
from q2q_sim.air.checked_wake import CheckedWake
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.wake import AirSetup, Push, Sources
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.plant.body.state_row import POS, VEL
from q2q_sim.plant.swarm import Swarm
from q2q_sim.scenarios import library

HERE = "test_uncompiled_wake"


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this module be imported by its name, as a user's is from the folder of a program."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


class SideWind:
    """Constant push, which remembers what it was told."""

    def reset(self, setup: AirSetup) -> None:
        """Forget what it was told."""
        self.setup = setup
        self.seen: list[Sources] = []

    def push(self, now: Sources) -> Push:
        """Return a push."""
        self.seen.append(now)
        n = self.setup.count
        return Push(np.tile([0.5, 0.0, -0.2], (n, 1)), np.zeros((n, 3)))


class NotANumber(SideWind):
    """Wake that fails in flight."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        found = super().push(now)
        return found if now.t < 0.1 else Push(found.acc * np.nan, found.torque)


class AtOnce(SideWind):
    """Wake that never gives a number."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(super().push(now).acc * np.nan, np.zeros((len(now.pos), 3)))


class Hurricane(SideWind):
    """Wake whose push is a number, but none of an air."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(np.full((len(now.pos), 3), 1e300), np.zeros((len(now.pos), 3)))


class Twister(SideWind):
    """Wake whose torque is none of an air."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(np.zeros((len(now.pos), 3)), np.full((len(now.pos), 3), -2.0))


class WrongShape(SideWind):
    """Wake without rows."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(np.zeros(3), np.zeros((len(now.pos), 3)))


class Ragged(SideWind):
    """Wake with rows of unequal length."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push([[0.0], [0.0, 0.0]], now.pos)  # type: ignore[arg-type]


class Tensor:
    """Array that refuses to be one of numpy's, as a tensor of torch that requires grad."""

    def __array__(self, *_: object, **__: object) -> None:
        """Fail."""
        raise RuntimeError("use detach()")


class Learned(SideWind):
    """Wake with such a tensor."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(now.pos, Tensor())  # type: ignore[arg-type]


class Words(SideWind):
    """Wake of another kind of array."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(now.pos.astype(str), now.pos)


class Chatty(SideWind):
    """Wake whose error has many lines, as numba's have."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        raise TypeError("Failed in nopython mode\n\nCannot determine type\n" + str(now))


class Quits(SideWind):
    """Wake that ends the program."""

    def reset(self, setup: AirSetup) -> None:
        """End the program."""
        raise SystemExit(setup.seed)


class Fails(SideWind):
    """Wake with a mistake in it."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return Push(now.pos[99:100], now.pos[[99]])


class NoReset:
    """Class that is no wake."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        raise AssertionError(now)


class Bare(SideWind):
    """Wake that returns no Push."""

    def push(self, now: Sources) -> Push:
        """Return a push."""
        return now.pos  # type: ignore[return-value]


def _swarm(wake: SideWind) -> Swarm:
    start = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.5, 0.0]])
    return Swarm(("cf1", "cf2"), CRAZYFLIE_2_0, start, wake)


def _hover(swarm: Swarm, steps: int) -> None:
    drive = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], (2, 1))
    swarm.step(np.tile([CRAZYFLIE_2_0.hover_thrust, 0.0, 0.0, 0.0], (steps, 2, 1)), drive)


def test_a_wake_is_asked_once_a_step_with_the_state_before_it() -> None:
    wake = SideWind()
    swarm = _swarm(wake)
    swarm.downwash()
    _hover(swarm, 5)
    swarm.downwash()
    np.testing.assert_allclose([now.t for now in wake.seen], 0.002 * np.arange(6), atol=1e-15)
    np.testing.assert_array_equal(wake.seen[0].pos, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]])
    np.testing.assert_array_equal(wake.seen[5].vel, swarm.state[:, VEL])
    np.testing.assert_allclose(wake.seen[0].thrust, CRAZYFLIE_2_0.hover_thrust)
    # under a constant push the vehicle moves by a t^2 / 2
    moved = swarm.state[0, POS] - [0.0, 0.0, 1.0]
    np.testing.assert_allclose(moved, 0.5 * 0.01**2 * np.array([0.5, 0.0, -0.2]), rtol=1e-9, atol=1e-15)


def test_a_flight_records_the_whole_push_of_a_named_class() -> None:
    scenario = replace(library.load("table6"), duration=0.3, air=f"{HERE}:SideWind")
    flight = fly(scenario, FlightOptions(mode="ignoring"))
    np.testing.assert_array_equal(flight.true_eta, np.broadcast_to([0.5, 0.0, -0.2], flight.true_eta.shape))


def test_the_wake_of_the_documentation_flies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[4] / "docs" / "airs.md").read_text(encoding="utf-8")
    (tmp_path / "my_wake.py").write_text(page.split("```python\n")[1].split("```")[0])
    monkeypatch.chdir(tmp_path)
    scenario = replace(library.load("table6"), duration=0.1, air="my_wake:MyWake")
    flight = fly(scenario, FlightOptions(mode="ignoring"))
    np.testing.assert_allclose(flight.true_eta[..., 0], 0.02 * flight.true_pos[..., 2], rtol=1e-12)


def test_a_class_in_a_folder_with_a_space_flies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "my airs"
    folder.mkdir()
    (folder / "spaced_wake.py").write_text(Path(__file__).read_text().split("class NotANumber")[0])
    monkeypatch.chdir(folder)
    scenario = replace(library.load("table6"), duration=0.1, air="spaced_wake:SideWind")
    flight = fly(scenario, FlightOptions(mode="ignoring"))
    np.testing.assert_array_equal(flight.true_eta[..., 0], 0.5)


def test_a_number_that_is_none_ends_the_flight_with_one_sentence() -> None:
    scenario = replace(library.load("table6"), duration=0.3, air=f"{HERE}:NotANumber")
    with pytest.raises(
        AirError, match=r":NotANumber: acc of vehicle 0 at 0.100 s is \[nan nan nan\]"
    ) as lines:
        fly(scenario, FlightOptions(mode="ignoring"))
    assert "\n" not in str(lines.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (f"{HERE}:AtOnce", r":AtOnce: acc of vehicle 0 at 0.000 s is \[nan nan nan\]; must be finite"),
        (
            f"{HERE}:Hurricane",
            r":Hurricane: acc of vehicle 0 at 0.000 s is \[1.e\+300 .*; must be finite and at most 1000 in",
        ),
        (
            f"{HERE}:Twister",
            r":Twister: torque of vehicle 0 at 0.000 s is \[-2. .*; must be finite and at most 1 in",
        ),
        (
            f"{HERE}:WrongShape",
            r":WrongShape: acc is float64 of shape \(3,\); must be floats of shape \(3, 3\)",
        ),
        (f"{HERE}:Fails", r":Fails: push raised IndexError: index 99 is out of bounds"),
        (
            f"{HERE}:Ragged",
            r":Ragged: acc is not an array \(ValueError: .*\); must be floats of shape \(3, 3\)$",
        ),
        (
            f"{HERE}:Learned",
            r":Learned: torque is not an array \(RuntimeError: use .*\); must be floats of shape \(3, 3\)$",
        ),
        (f"{HERE}:Words", r":Words: acc is <U32 of shape \(3, 3\); must be floats of shape"),
        (f"{HERE}:Chatty", r":Chatty: push raised TypeError: Failed in nopython mode$"),
        (f"{HERE}:Quits", r":Quits: reset raised SystemExit: 0$"),
        (f"{HERE}:NoReset", r":NoReset: the class needs methods reset\(setup\) and push\(now\)"),
        (f"{HERE}:Bare", r":Bare: push returned a ndarray: return a Push"),
        (f"{HERE}:Missing", "has no class Missing"),
        ("no_such_module:Wind", r"no_such_module cannot be imported \(ModuleNotFoundError"),
    ],
)
def test_a_class_that_cannot_be_flown_in_is_refused_before_the_flight(name: str, message: str) -> None:
    with pytest.raises(AirError, match=message) as said:
        find_air(name)
    assert "\n" not in str(said.value)


def test_a_wake_is_tried_and_then_reset() -> None:
    wake = SideWind()
    CheckedWake(wake).reset(AirSetup(CRAZYFLIE_2_0, 2, 0.002, 0))
    assert wake.seen == []
