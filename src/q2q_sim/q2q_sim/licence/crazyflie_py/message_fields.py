"""Arguments of a program as fields of ROS messages.

A field of type float64 or float32 takes a Python float. Of an int, rclpy on Humble raises an AssertionError,
and on Jazzy the serialised message has another number: Float64(data=1) arrives as 5e-324. Both are mistakes
of the program, so an int raises here too. A duration reaches its message by way of whole nanoseconds, and may
be any real number. The value of a parameter is converted to its type: setParam catches every exception,
warns, and goes on.
"""

from collections.abc import Mapping, Sequence
from numbers import Number
from typing import Protocol, runtime_checkable

import numpy as np

from q2q_model.signals.stamps import NANOSECONDS
from q2q_model.signals.values import Array, Three
from q2q_sim.firmware.parameters.parameter_table import TABLE

SECONDS_END = 2**31
"""Beyond the seconds of a builtin_interfaces/Duration, an int32."""
NUMBERS: Mapping[str, int] = {one.name: number for number, one in enumerate(TABLE)}
"""Number of each parameter."""


@runtime_checkable
class Listed(Protocol):
    """Anything that makes a list of itself: an array of numpy or of Python, a series of pandas."""

    def tolist(self) -> object:
        """Return a list."""
        ...


def real(value: object, what: str) -> float:
    """Return a float; raise TypeError for what a ROS message would refuse or garble."""
    if not isinstance(value, float):
        raise TypeError(
            f"{what} = {value!r} is of type {type(value).__name__}: a ROS message needs a float, like 1.0; "
            "Humble refuses and Jazzy garbles anything else"
        )
    return float(value)


def three(values: object, what: str) -> Three:
    """Return three floats of a sequence or array."""
    if not isinstance(values, Sequence | np.ndarray):
        raise TypeError(f"{what} = {values!r}; must be three floats")
    x, y, z = (real(values[k], f"{what}[{k}]") for k in range(3))
    return x, y, z


def seconds(value: float, what: str) -> float:
    """Return a duration [s] in whole nanoseconds, as rclpy.duration.Duration makes it of any real number."""
    message = f"{what} = {value!r}; must be seconds between -2^31 and 2^31"
    if not isinstance(value, Number | np.generic | np.ndarray) or isinstance(value, np.character):
        raise TypeError(message)
    try:
        nanoseconds = int(value * NANOSECONDS)
    except TypeError as error:
        raise TypeError(message) from error
    except ValueError as error:
        raise ValueError(message) from error
    except OverflowError as error:
        raise OverflowError(message) from error
    if abs(nanoseconds) >= SECONDS_END * NANOSECONDS:
        raise OverflowError(message)
    return nanoseconds / NANOSECONDS


def coefficients(values: object, what: str) -> Array:
    """Return the coefficients of a polynomial; crazyflie_py calls their `tolist`, which a list has not."""
    if not isinstance(values, Listed):
        raise TypeError(
            f"{what} = {values!r} is of type {type(values).__name__}: crazyflie_py needs a numpy array, "
            "like np.array([0.0, 1.0])"
        )
    return np.asarray(values.tolist(), dtype=np.float64)


def whole(value: object, what: str, most: int) -> int:
    """Return a whole number from 0 to `most`."""
    if not isinstance(value, int) or not 0 <= value <= most:
        raise TypeError(f"{what} = {value!r}; must be an int in [0, {most}]")
    return int(value)


def flag(value: object, what: str) -> bool:
    """Return a truth value."""
    if not isinstance(value, bool):
        raise TypeError(f"{what} = {value!r}; must be True or False")
    return value


def value_to_send(name: str, value: float) -> float | None:
    """Return the value that setParam sends; None, with a warning, if there is none."""
    try:
        return float(value) if TABLE[NUMBERS[name]].kind == "float" else int(value)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        print(f"setParam: {name} = {value!r} is not set: {error!r}")
        return None
