"""Hint to the name that was meant, for errors about an unknown one."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

RENAMED: Mapping[str, tuple[str, ...]] = {
    "degraded_s": ("degraded_after_s",),
    "hold_s": ("hold_after_s",),
    "level_s": ("level_after_s",),
    "land_s": ("land_after_s", "landing_duration_min"),
    "cut_s": ("cut_after_s",),
    "patience_s": ("step_timeout_s",),
    "glide_speed": ("transit_speed",),
    "glide_s": ("transit_duration_min",),
    "glide_eps": ("transit_eps",),
    "glide_d": ("transit_d",),
    "speed_max": ("return_speed_max",),
    "mode": ("axes",),
    "answer": ("wait_for",),
}
"""Parameter of an earlier version -> its names now, of which a node has one. Others are spelt alike."""


def name_hint(given: str, known: Iterable[str]) -> str:
    """Return a question with the known name nearest to the given one, or the list of all if none is near."""
    names = list(known)
    near = get_close_matches(given, names, n=1)
    return f"did you mean {near[0]}?" if near else f"choose one of {', '.join(names)}"


def parameter_hint(given: str, known: Iterable[str]) -> str:
    """Return the present name of a parameter that was renamed, or the hint to the nearest one."""
    names = list(known)
    now = [one for one in RENAMED.get(given, ()) if one in names]
    return f"it is now {now[0]}" if now else name_hint(given, names)
