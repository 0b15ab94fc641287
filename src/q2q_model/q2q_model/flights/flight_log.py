"""Additional columns of a recorded flight, under the names of their source."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.thrust_map import PWM_FULL

MOTORS = ("pwm1", "pwm2", "pwm3", "pwm4")
"""Columns of the motors' duties."""


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


def motor_duty(log: FlightLog) -> Array:
    """Return the duty of every motor in a log, 0 to 1, (T, n, 4), also of one that counts to PWM_FULL."""
    logged = np.stack([log.column(motor) for motor in MOTORS], axis=-1)
    return logged / (PWM_FULL if np.nanmax(logged, initial=0.0) > 1.0 else 1.0)
