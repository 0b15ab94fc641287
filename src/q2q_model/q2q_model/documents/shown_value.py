"""Wrong values in errors: a few characters, however long or deep a document is."""

from reprlib import Repr

LONGEST = 32
"""Most characters of a wrong value in an error."""
_REPR = Repr()
_REPR.maxdict, _REPR.maxlist, _REPR.maxstring, _REPR.maxlong = 3, 4, LONGEST, LONGEST


def shown_value(value: object) -> str:
    """Return how Python writes a value, cut to LONGEST characters."""
    text = _REPR.repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
