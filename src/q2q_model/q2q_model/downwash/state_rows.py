"""Rows of a state for compiled code, which checks no bounds."""

import numpy as np

from q2q_model.signals.values import Array, SwarmState


def state_rows(state: SwarmState) -> Array:
    """Return position, velocity, quaternion and age of every vehicle, (n, 11).

    Raises:
        ValueError: an array does not have a row for each name.
    """
    count = len(state.names)
    try:
        columns = state.pos, state.vel, state.quat, state.age[:, None]
        rows = np.concatenate(columns, axis=1, dtype=np.float64)
        if rows.shape == (count, 11) and state.pos.shape == (count, 3) and state.status.shape == (count,):
            return rows
    except (AttributeError, TypeError, ValueError) as error:  # lists, or rows of different numbers
        raise _misfit(state) from error
    raise _misfit(state)


def _misfit(state: SwarmState) -> ValueError:
    """Return an error that names the first array of a wrong shape."""
    count = len(state.names)
    shapes = {"pos": (count, 3), "vel": (count, 3), "quat": (count, 4), "age": (count,), "status": (count,)}
    for name, shape in shapes.items():
        given = getattr(state, name)
        if not isinstance(given, np.ndarray) or given.shape != shape:
            what = f"of shape {given.shape}" if isinstance(given, np.ndarray) else f"a {type(given).__name__}"
            return ValueError(f"{name} of a state of {count} names is {what}; must be an array {shape}")
    return ValueError("the arrays of a state must be of real numbers")
