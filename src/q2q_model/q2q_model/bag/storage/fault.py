"""Say what is wrong with a bag, or what was mended to read it."""

import warnings


class BagError(ValueError):
    """Error for a bag that cannot be read or written as asked; the message names the remedy."""


class BagRepairWarning(UserWarning):
    """State a repair: something of the bag was lost or bent, and the rest is used."""


def state_repairs(repairs: tuple[str, ...]) -> None:
    """Warn of every repair, once each."""
    for repair in repairs:
        warnings.warn(repair, BagRepairWarning, stacklevel=3)
