"""What of a flight was flown: its vehicles that took off, and its pieces from one hole to the next.

What a vehicle did in a hole is not known, and it ends in a state of its own. A flight with holes (no frame, a
vehicle out of sight, a jump of the clock, two flights in one bag) is one piece from each hole to the next.
"""

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.flight import Flight, of_rows
from q2q_model.signals.values import Array, Mask, Rows

SHORTEST = 2.0
"""Minimum duration of a record [s], about the time constant of the altitude loop."""
HOLE_S, HOLE_PERIODS = 0.3, 3.0
"""Time without a row from which there is a hole [s], and at least in median periods: a third of the time
constant of the altitude loop."""
STILL = 0.02
"""Distance from its median place that a vehicle on the ground does not leave [m]: far above the noise of
motion capture, and below the wander of a vehicle that takes off."""
MOSTLY = 0.99
"""Share of positions within that distance [-]; others are outliers."""


def standing_vehicles(flight: Flight) -> list[str]:
    """Return the vehicles without a reference or a thrust that stay where they are."""
    known, found = _referred(flight), []
    pos = np.where(np.isfinite(flight.pos), flight.pos, flight.mocap_pos)
    for i, name in enumerate(flight.names):
        place = pos[np.isfinite(pos[:, i]).all(axis=1), i]
        if known[:, i].any() or (flight.thrust[:, i] > 0.0).any() or not len(place):
            continue
        away = np.abs(place - np.median(place, axis=0)).max(axis=1)
        if np.quantile(away, MOSTLY) < STILL:
            found.append(name)
    return found


def pieces_between_holes(flight: Flight) -> tuple[list[Flight], list[str]]:
    """Return the pieces of a flight from hole to hole that are long enough, and a remark on holes."""
    whole = _whole_rows(flight)
    t, steps = flight.t[whole], np.diff(flight.t[whole])
    usual = float(np.median(steps)) if steps.size else 0.0
    holes = np.flatnonzero(steps > max(HOLE_S, HOLE_PERIODS * usual))
    if not holes.size:
        return [flight], []
    ends = zip([0, *(holes + 1)], [*holes, t.size - 1], strict=True)
    parts = [slice(int(whole[first]), int(whole[last]) + 1) for first, last in ends]
    long = [part for part in parts if flight.t[part][-1] - flight.t[part][0] >= SHORTEST]
    if not long:
        raise _too_short(flight)
    remark = _holes_note(flight.name, t[holes], steps[holes], len(parts) - len(long))
    return [of_rows(flight, part) for part in long], [remark]


def _holes_note(name: str, t: Array, seconds: Array, left_out: int) -> str:
    worst = int(np.argmax(seconds))
    which = f"hole of {seconds[worst]:.1f} s at t = {t[worst]:.2f} s"
    several = f"{len(t)} holes, the longest a {which}" if len(t) > 1 else which
    short = f"; without {counted(left_out, 'piece')} shorter than {SHORTEST:g} s" if left_out else ""
    return f"{name}: {several}, or a jump of the clock: data are not joined across it{short}"


def common_rows(flight: Flight) -> slice:
    """Return the rows from the first to the last with position and reference of every vehicle."""
    whole = _whole_rows(flight)
    if whole.size == 0 or flight.t[whole[-1]] - flight.t[whole[0]] < SHORTEST:
        raise _too_short(flight)
    return slice(int(whole[0]), int(whole[-1]) + 1)


def _whole_rows(flight: Flight) -> Rows:
    """Return the rows with position and reference of every vehicle, (k,)."""
    return np.flatnonzero((placed_rows(flight) & _referred(flight)).all(axis=1))


def _referred(flight: Flight) -> Mask:
    """Return where there is an altitude reference, also one that is held, (T, n)."""
    return np.asarray(np.isfinite(flight.safe_pos[..., 2]) | np.isfinite(flight.ref_pos[..., 2]))


def placed_rows(flight: Flight) -> Mask:
    """Return where a position is known, (T, n)."""
    return finite_rows(flight.mocap_pos) | finite_rows(flight.pos)


def finite_rows(values: Array) -> Mask:
    """Return where all components are finite, (T, n)."""
    return np.asarray(np.isfinite(values).all(axis=-1))


def _too_short(flight: Flight) -> ValueError:
    known = {"reference": _referred(flight), "position": placed_rows(flight)}
    lacking = [
        f"no {what} of {name}"
        for what, rows in known.items()
        for name, own in zip(flight.names, rows.T, strict=True)
        if not own.any()
    ]
    which = f": there is {', '.join(lacking)}" if lacking else ""
    return ValueError(
        f"flight {flight.name}: positions and references of {', '.join(flight.names)} never last for "
        f"{SHORTEST} s together{which}; record the topics mocap (or state) and reference of one flight"
    )
