"""Error and warning of bag files."""

import warnings


class BagError(ValueError):
    """Error for a bag that cannot be read or written; the message names the remedy."""


class BagRepairWarning(UserWarning):
    """Warning of a repair: part of the bag was lost or changed, and the rest is used."""


def warn_of_repairs(repairs: tuple[str, ...]) -> None:
    """Issue a BagRepairWarning for every repair."""
    for repair in repairs:
        warnings.warn(repair, BagRepairWarning, stacklevel=3)
