"""Give every random thing of a flight its own stream of numbers, so that none shifts another.

One seed names a flight. A purpose ("vicon noise", "radio loss") names a stream: switching one thing off, or
drawing more of it, leaves all the others as they were. Source: numpy's SeedSequence, spawned by name.
"""

from zlib import crc32

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of `purpose` in the flight named by `seed` (0 or above)."""
    return np.random.default_rng(np.random.SeedSequence([seed, crc32(purpose.encode())]))
