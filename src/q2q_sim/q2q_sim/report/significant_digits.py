"""Numbers as a table shows them: three significant digits, at most four decimals, never an exponent."""

import math

DIGITS, DECIMALS = 3, 4
"""Significant digits; most decimals: 0.1 mm is the noise of motion capture."""
CM, MM = 1e2, 1e3
"""Centimetres and millimetres in a metre."""


def significant_digits(value: float | None, digits: int = DIGITS) -> str:
    """Return a number as text: "0.131", "2060", "0.0003"; a count as it is; "-" if it is unknown."""
    if isinstance(value, int):
        return str(value)
    if value is None or not math.isfinite(value):
        return "-"
    rounded = float(f"{value:.{digits - 1}e}")
    before = math.floor(math.log10(abs(rounded))) + 1 if rounded else 0
    text = f"{rounded:.{min(max(digits - before, 0), DECIMALS)}f}"
    return "0" if not float(text) else text


def centimetres(metres: float) -> str:
    """Return a length [m] in centimetres: "34 cm", "5.2 cm", "0.6 cm"."""
    return f"{significant_digits(CM * metres, 2)} cm"
