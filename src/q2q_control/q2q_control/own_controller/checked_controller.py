"""Controller of a user's class, with every command checked.

A law without limits may ask for more than the motors give, and the simulator limits that; the bounds here
are those of another unit: grams or m/s^2 for newtons, degrees for radians.
"""

import sys
from collections.abc import Callable, Mapping
from functools import partial
from math import pi
from numbers import Real
from pathlib import Path
from traceback import walk_tb

import numpy as np

from q2q_control.controller import Controller, SensingController
from q2q_model.own_class import error_line
from q2q_model.signals.checked_array import checked_array, own_copy
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    Mask,
    Names,
    Status,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
    index_of,
    rows_by_name,
)
from q2q_model.vehicle.constants import Vehicle

LARGEST_THRUST = 10.0
"""Largest thrust over the vehicle's own [-]; the weight of a Crazyflie in m/s^2 is 12 times that or more."""
LARGEST_TILT = pi
"""Largest roll and pitch [rad]."""
LARGEST_YAW_RATE = 35.0
"""[rad/s], the range of the BMI088's gyroscopes, 2000 degrees/s."""


class ControllerOutputError(ValueError):
    """Error of a user's controller: its command cannot be flown, or its class raised an error."""


class CheckedController:
    """Controller that raises ControllerOutputError where its class fails or returns what cannot be flown."""

    def __init__(self, controller: Controller, vehicle: Vehicle) -> None:
        """Take a controller and the vehicle that it flies."""
        self._controller = controller
        self._file = getattr(sys.modules.get(type(controller).__module__), "__file__", "")
        self._unsensed: ControllerOutputError | None = None
        self._name = f"controller {type(controller).__module__}:{type(controller).__qualname__}"
        self._bounds: Mapping[str, tuple[float, str]] = {
            "thrust": (LARGEST_THRUST * vehicle.thrust_max, "N"),
            "roll": (LARGEST_TILT, "rad"),
            "pitch": (LARGEST_TILT, "rad"),
            "yaw_rate": (LARGEST_YAW_RATE, "rad/s"),
        }

    @property
    def senses(self) -> bool:
        """Return whether the class takes inertial sensors."""
        return isinstance(self._controller, SensingController)

    def sense(self, imu: SwarmImu) -> None:
        """Give inertial sensors to the class if it takes them; its error is raised by the next update."""
        if not isinstance(self._controller, SensingController):
            return
        try:
            self._controller.sense(own_copy(imu))
        except (Exception, SystemExit) as error:  # noqa: BLE001  of a user's class
            self._unsensed = self._failed("sense", error)

    def reset(self) -> None:
        """Reset the controller."""
        self._unsensed = None
        try:
            self._controller.reset()
        except (Exception, SystemExit) as error:
            raise self._failed("reset", error) from error

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None = None
    ) -> SwarmCommand:
        """Return the controller's command, in the order of the setpoint's vehicles."""
        if self._unsensed is not None:
            unsensed, self._unsensed = self._unsensed, None
            raise unsensed
        felt = None if interference is None else own_copy(interference)
        try:
            command = self._controller.update(own_copy(state), own_copy(setpoint), felt)
        except (Exception, SystemExit) as error:
            raise self._failed("update", error) from error
        self._check_tick(command, state, setpoint)
        known = partial(_known, command.names, state, setpoint, interference)
        rows = index_of(setpoint.names, command.names)
        return SwarmCommand(
            t=command.t,
            names=setpoint.names,
            thrust=self._within(command, "thrust", known)[rows],
            roll=self._within(command, "roll", known)[rows],
            pitch=self._within(command, "pitch", known)[rows],
            yaw_rate=self._within(command, "yaw_rate", known)[rows],
            status=self._status(command)[rows],
        )

    def _check_tick(self, command: object, state: SwarmState, setpoint: SwarmSetpoint) -> None:
        """Check that it is a command of this tick for its vehicles."""
        if not isinstance(command, SwarmCommand):
            raise self._wrong(f"update returned a {type(command).__name__}: return a SwarmCommand")
        strings = isinstance(command.names, tuple) and all(isinstance(one, str) for one in command.names)
        if not strings or sorted(command.names) != sorted(setpoint.names):
            raise self._wrong(f"names are {command.names!r}; must be {setpoint.names}, in any order")
        t: object = command.t
        if not _is_tick(t, state, setpoint):
            raise self._wrong(f"t is {t!r}; must be that of the setpoint, {setpoint.t} s")

    def _within(self, command: SwarmCommand, what: str, known: Callable[[], Mask]) -> Array:
        given = self._numbers(what, getattr(command, what), len(command.names)).astype(np.float64)
        most, unit = self._bounds[what]
        wrong = ~(np.abs(given) <= most)
        if wrong.any() and (wrong := wrong & (known() | ~np.isnan(given))).any():
            row = int(np.argmax(wrong))
            raise self._wrong(
                f"{what} of {command.names[row]} at {command.t:.3f} s is {given[row]:g}; must be finite and "
                f"at most {most:.3g} {unit} in magnitude"
            )
        return given

    def _status(self, command: SwarmCommand) -> Status:
        given = self._numbers("status", command.status, len(command.names))
        if not np.isin(given, list(CommandStatus)).all():
            raise self._wrong(f"status is {given}; must be a CommandStatus, 0 to {max(CommandStatus):d}")
        return given.astype(np.uint8)

    def _numbers(self, what: str, output: object, count: int) -> Array:
        try:
            return checked_array(output, (count,))
        except ValueError as error:
            raise self._wrong(f"{what} {error}") from error

    def _failed(self, what: str, error: BaseException) -> ControllerOutputError:
        return self._wrong(f"{what} raised {error_line(error)} ({self._line_of(error)})")

    def _line_of(self, error: BaseException) -> str:
        """Return file and line of an error: the last ones in the class's module, else where it was raised."""
        lines = [(frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__)]
        own = [one for one in lines if one[0] == self._file]
        file, line = (own or lines)[-1]
        return f"{Path(file).name}, line {line}"

    def _wrong(self, message: str) -> ControllerOutputError:
        return ControllerOutputError(f"{self._name}: {message}")


def _is_tick(given: object, state: SwarmState, setpoint: SwarmSetpoint) -> bool:
    """Return whether a time is a number, that of the state or the setpoint."""
    t = given.item() if isinstance(given, np.ndarray) and given.ndim == 0 else given
    return isinstance(t, Real) and any(abs(float(t) - one.t) < SAME_STAMP for one in (state, setpoint))


def _known(names: Names, state: SwarmState, setpoint: SwarmSetpoint, felt: Interference | None) -> Mask:
    """Return for which vehicles all that a controller reads is finite, (n,): others may get NaN."""
    read = [(state.names, one) for one in (state.pos, state.vel, state.quat, state.ang_vel_body)]
    read += [(setpoint.names, one) for one in (setpoint.pos, setpoint.vel, setpoint.acc)]
    read += [(setpoint.names, one[:, None]) for one in (setpoint.yaw, setpoint.yaw_rate)]
    read += [] if felt is None else [(felt.names, felt.acc)]
    finite = [rows_by_name(np.asarray(np.isfinite(one).all(axis=1)), have, names) for have, one in read]
    return np.asarray(np.logical_and.reduce(finite))
