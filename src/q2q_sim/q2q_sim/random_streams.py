"""Independent random stream for each source of randomness in a flight.

The seed names the flight, the purpose ("vicon noise", "radio loss") names the stream: switching one source
off, or drawing more from it, leaves all others unchanged. Source: numpy's SeedSequence, spawned by name.
"""

from zlib import crc32

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator for `purpose` in the flight with this `seed` (0 or above)."""
    return np.random.default_rng(np.random.SeedSequence([seed, crc32(purpose.encode())]))
