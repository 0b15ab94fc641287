"""Values of parameters that a program sets, as crazyflie_py converts them.

crazyflie_py catches every exception in getParam and setParam, warns, and goes on.
"""

from collections.abc import Mapping

from q2q_sim.firmware.parameters.parameter_table import TABLE

NUMBERS: Mapping[str, int] = {one.name: number for number, one in enumerate(TABLE)}
"""Number of each parameter."""


def number_set(name: str, value: float) -> float | None:
    """Return the value that setParam sends; None, with a warning, if there is none."""
    try:
        return float(value) if TABLE[NUMBERS[name]].kind == "float" else int(value)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        print(f"setParam: {name} = {value!r} is not set: {error!r}")
        return None
