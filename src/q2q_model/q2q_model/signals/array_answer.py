"""Check of an array that a user's code answers with."""

import numpy as np

from q2q_model.signals.values import Array


def array_answer(answer: object, shape: tuple[int, ...]) -> Array:
    """Return numbers of a shape as an array.

    Raises:
        ValueError: they are none; the message goes on after the name of what was answered.
    """
    needed = f"floats of shape {shape} are needed"
    try:
        given = np.asarray(answer)
    except (TypeError, ValueError) as error:
        raise ValueError(f"is no array ({type(error).__name__}: {error}): {needed}") from error
    if given.shape != shape or given.dtype.kind not in "fiu":
        raise ValueError(f"is {given.dtype} of shape {given.shape}: {needed}")
    return given
