"""Stamps in whole nanoseconds, their ROS parts (sec, nanosec), and times in seconds.

Every node converts by these functions: sec + nanosec * 1e-9 and (sec * 10^9 + nanosec) * 1e-9 differ in the
last bit for 40 % of stamps.
"""

NANOSECONDS = 1_000_000_000
"""Nanoseconds per second."""
TICK_NS = 10_000_000
"""Period of the ticks [ns]: that of motion capture at 100 Hz."""
TICK_S = TICK_NS * 1e-9
"""The same [s]."""
END_S = 2**31 - 86_400
"""Stamps from here on are refused [s]: `sec` is an int32, and stamps of up to a day later must fit, too."""

SAME_INSTANT = 1e-9
"""Difference of two times of one instant at most [s]: their rounding in float64, and that of sums."""
SAME_STAMP = 1e-6
"""Difference of two readings of one stamp at most [s]: a float near 1e9 s resolves 1e-7 s."""
STALLED = 100
"""Messages with one and the same stamp from which their clock stands still: a lost one is sent again a few
times."""


class BadStampError(ValueError):
    """Error for a stamp that is invalid, or close to the end of its range."""


def stamp_from_parts(sec: int, nanosec: int) -> int:
    """Return the stamp [ns] of builtin_interfaces/Time.

    Raises:
        BadStampError: `nanosec` is a second or more, or `sec` is beyond END_S.
    """
    if not (-END_S < sec < END_S and nanosec < NANOSECONDS):
        allowed = f"sec must be within {END_S} and nanosec below {NANOSECONDS}"
        raise BadStampError(f"stamp of sec {sec}, nanosec {nanosec}; {allowed}")
    return int(sec) * NANOSECONDS + int(nanosec)


def stamp_parts(stamp_ns: int) -> tuple[int, int]:
    """Return sec and nanosec of builtin_interfaces/Time."""
    return divmod(stamp_ns, NANOSECONDS)


def time_from_stamp(stamp_ns: int) -> float:
    """Return the time [s] of a stamp [ns]."""
    return stamp_ns * 1e-9


def stamp_from_time(t: float) -> int:
    """Return the stamp [ns] of a time [s]; exact below 2^50 ns (13 days): three roundings of 2^-53."""
    return round(t * 1e9)
