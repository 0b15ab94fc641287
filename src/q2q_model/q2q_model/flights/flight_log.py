"""Additional columns of a recorded flight, under the names of their source."""

from dataclasses import dataclass

from q2q_model.signals.values import Array, Names


@dataclass(frozen=True, slots=True)
class FlightLog:
    """Extra columns of a flight, one row a tick."""

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
