"""Additional columns of a recorded flight, under the names of their source."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.thrust_map import PWM_FULL

MOTORS = ("pwm1", "pwm2", "pwm3", "pwm4")
"""Columns of the motors' duties."""
LEAST_PWM = 5000.0
"""Smallest median of turning motors that is taken for PWM: pulses of ESCs reach 2000 us, idle is 7000."""


@dataclass(frozen=True, slots=True)
class FlightLog:
    """Extra columns of a flight, one row per tick."""

    t: Array
    """Capture stamps [s], rising, (T,)."""
    names: Names
    """The n vehicles."""
    columns: tuple[str, ...]
    """The K columns."""
    units: tuple[str, ...]
    """Unit of each column, empty for a pure number, (K,)."""
    values: Array
    """(T, n, K), in `units`; NaN where missing."""

    def column(self, name: str) -> Array:
        """Return one column, (T, n); raise KeyError for an unknown one."""
        if name not in self.columns:
            raise KeyError(f"the flight's log has no column {name!r}; it has {', '.join(self.columns)}")
        return self.values[:, :, self.columns.index(name)]


def log_at(log: FlightLog, t: Array, names: Names) -> FlightLog:
    """Return a log at the ticks (T,) and vehicles of its flight; NaN at ticks that it lacks.

    Raises:
        ValueError: the log lacks a vehicle, or has no row at any tick.
    """
    if log.names == names and log.t.shape == t.shape and bool(np.all(np.abs(log.t - t) <= SAME_STAMP)):
        return log
    if not set(names) <= set(log.names):
        raise ValueError(
            f"its log has vehicles {', '.join(log.names)}, not {', '.join(names)}: log all vehicles by name, "
            "or record the flight without a log"
        )
    order = np.argsort(log.t, kind="stable")
    row = np.clip(np.searchsorted(log.t[order], t - SAME_STAMP), 0, log.t.size - 1)
    same = np.abs(log.t[order][row] - t) <= SAME_STAMP
    if not same.any():
        raise ValueError(
            f"none of the {log.t.size} rows of its log ({log.t.min():.3f} to {log.t.max():.3f} s) is at one "
            f"of its {t.size} ticks ({t[0]:.3f} to {t[-1]:.3f} s): stamp rows with the ticks"
        )
    own = log.values[order][row][:, [log.names.index(name) for name in names]]
    return FlightLog(t, names, log.columns, log.units, np.where(same[:, None, None], own, np.nan))


def motor_duty(log: FlightLog, flight: str) -> Array:
    """Return the duty of every motor in the log of a flight, 0 to 1, (T, n, 4), also from PWM to PWM_FULL.

    Each vehicle's scale is that of the median of its motors while they turn: single values may be wrong.

    Raises:
        ValueError: the motors of a vehicle have another scale.
    """
    logged = np.stack([log.column(motor) for motor in MOTORS], axis=-1)
    full = [_full_duty(f"flight {flight}", name, logged[:, i]) for i, name in enumerate(log.names)]
    return np.asarray(logged / np.array(full)[:, None])


def _full_duty(flight: str, name: str, logged: Array) -> float:
    """Return the value at full duty of the motors of a vehicle, (T, 4)."""
    turning = logged[logged > 0.0]
    usual = float(np.median(turning)) if turning.size else 0.0
    if usual <= 1.0:
        return 1.0
    if LEAST_PWM <= usual <= PWM_FULL:
        return PWM_FULL
    raise ValueError(
        f"{flight}: {MOTORS[0]} to {MOTORS[-1]} of {name} are {usual:.4g} in the median and reach "
        f"{turning.max():.4g}; must be duties from 0 to 1, or PWM from 0 to {PWM_FULL}: a column map scales "
        "those of a table (bag_import --columns), percent by 0.01"
    )
