"""One flight from the micro-SD logs of its vehicles: common clock, common rows, our columns.

One broadcast starts logging in all vehicles, so their clocks are joined there: clocks that count from the
start of logging are common already; of others, which count from each vehicle's own switching on, each begins
at its first row. Rows are interpolated from the first to the last row that all vehicles have, to 100 Hz, or,
if all logs are slower than 40 Hz, to the whole multiple of 10 ms nearest to the period of the fastest. What
lies in a hole of a log, HOLE_PERIODS of its own, is marked in the column `gap`; the rows at its ends are
not.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from q2q_model.flights.tables.column_map import FIRMWARE, ColumnMap, map_columns, require_sources
from q2q_model.flights.tables.flight_table import POS, QUAT
from q2q_model.flights.tables.usd_log import UsdLog
from q2q_model.geometry.quaternion32 import decompress_quat
from q2q_model.geometry.rotations import continuous_quats, quat_from_euler
from q2q_model.signals.values import Array

STEP_S = 0.01
"""Shortest period of a flight's ticks [s]."""
HOLE_PERIODS = 2.5
"""Periods of a log, of STEP_S if it is faster, above which more than a row is missing [-]."""
LONGEST_S = 4 * 3600.0
"""Longest flight [s]: stamps further apart are damaged; a battery lasts 7 min, a wired vehicle longer."""
LOGGING_CLOCK_S = 2.0
"""First row up to which a clock counts from the start of logging [s]: 0.01 s in the logs of
aerorobotics/neural-swarm, more where blocks of first rows are damaged; nobody sends a broadcast as soon after
switching a vehicle on."""
LIKELY_S = 0.5
"""First row up to which that is certain [s]: above, vehicles may log from their own switching on."""
ROUNDING = 1e-6
"""Share of a period that times are rounded by."""
OWN_CLOCKS = (
    f"first rows after {LIKELY_S:g} s mean lost blocks or, with enable-on-startup of the deck, separate "
    "clocks of the vehicles: then they are not at one time"
)
ATTITUDE = ("stateEstimate.roll", "stateEstimate.pitch", "stateEstimate.yaw")
"""Degrees; the firmware's pitch is nose up: minus theta."""
QUAT_BITS = "stateEstimateZ.quat"


def columns_of_logs(logs: Mapping[str, UsdLog], given: ColumnMap | None = None) -> dict[str, Array]:
    """Return the columns t and `<vehicle>_<column>` of a flight (q2q_model.flights.tables.flight_table).

    Args:
        logs: Vehicle -> its log.
        given: Sources of columns, before those of FIRMWARE.

    Raises:
        ValueError: a vehicle has no position, a given source is in no log, or the logs have less than a
            second or more than `LONGEST_S` in common.
    """
    variables = sorted({name for log in logs.values() for name in log.variables})
    require_sources(given or {}, variables, variables)
    chosen = {**FIRMWARE, **(given or {})}
    shared = share_clock(logs.values())
    clocks = {name: log.t if shared else log.t - log.t[0] for name, log in logs.items()}
    begin, end = max(t[0] for t in clocks.values()), min(t[-1] for t in clocks.values())
    if end - begin > LONGEST_S:
        raise ValueError(
            f"the logs span {end - begin:.0f} s (maximum {LONGEST_S:.0f} s): time stamps may be damaged"
        )
    if end - begin < 1.0:
        raise ValueError(f"the logs have {max(end - begin, 0.0):.2f} s in common (minimum 1 s)")
    step = _step(min(_period(log.t) for log in logs.values()))
    first, last = np.ceil(begin / step - ROUNDING), np.floor(end / step + ROUNDING)
    t = step * np.arange(first, last + 1.0)
    found = {"t": t}
    for name, log in logs.items():
        columns = _columns(log.variables, chosen)
        missing = [one for one in POS if one not in columns]
        if missing:
            raise ValueError(
                f"{name} logs no {', '.join(missing)}; name its variables in a column map: it logs "
                f"{', '.join(log.variables)}"
            )
        rows = {key: np.interp(t, clocks[name], values) for key, values in columns.items()}
        found |= {f"{name}_{key}": values for key, values in (rows | _gap(t, clocks[name])).items()}
    return found


def share_clock(logs: Iterable[UsdLog]) -> bool:
    """Return whether the clocks of logs count from the start of logging, which is common."""
    return all(log.t[0] <= LOGGING_CLOCK_S for log in logs)


def clock_note(logs: Mapping[str, UsdLog]) -> str:
    """Return in words how the clocks of logs are joined; empty for one log."""
    if len(logs) < 2:
        return ""
    starts = ", ".join(f"{name} {log.t[0]:.3f} s" for name, log in logs.items())
    if share_clock(logs.values()):
        note = f"clocks count from the start of logging: taken as common ({starts})"
        late = any(log.t[0] > LIKELY_S for log in logs.values())
        return f"{note}; {OWN_CLOCKS}" if late else note
    return f"clocks count from switching on: all first rows are taken as one time ({starts})"


def _columns(variables: Mapping[str, Array], chosen: ColumnMap) -> dict[str, Array]:
    found = map_columns(variables, chosen)
    if not all(one in found for one in QUAT) and (quat := _quat(variables)) is not None:
        found |= dict(zip(QUAT, continuous_quats(quat).T, strict=True))
    return found


def _quat(variables: Mapping[str, Array]) -> Array | None:
    """Return attitudes x y z w, (T, 4), from packed bits or from angles; None where neither is logged."""
    if QUAT_BITS in variables:
        return np.array([decompress_quat(int(bits)) for bits in variables[QUAT_BITS]])
    if all(one in variables for one in ATTITUDE):
        roll, pitch, yaw = (np.deg2rad(variables[one]) for one in ATTITUDE)
        return quat_from_euler(roll, -pitch, yaw)
    return None


def _period(clock: Array) -> float:
    """Return the usual time from row to row [s], at least STEP_S."""
    return max(float(np.median(np.diff(clock))), STEP_S)


def _step(period: float) -> float:
    """Return the period of ticks [s]: STEP_S for logs of 40 Hz or more."""
    multiple = round(period / STEP_S - ROUNDING)
    return STEP_S * multiple if multiple > 2 else STEP_S


def _gap(t: Array, clock: Array) -> dict[str, Array]:
    after = np.clip(np.searchsorted(clock, t), 1, len(clock) - 1)
    before, period = after - 1, _period(clock)
    on_row = np.minimum(np.abs(t - clock[before]), np.abs(clock[after] - t)) <= ROUNDING * period
    hole = clock[after] - clock[before] > HOLE_PERIODS * period
    return {"gap": (hole & ~on_row).astype(np.float64)}
