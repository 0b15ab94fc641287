"""Column map: which column of ours comes from which column or log variable of other software, and its unit.

    columns:
      x: stateEstimate.x                        # same unit
      vbat: {from: pm.vbatMV, scale: 0.001}     # ours = scale * theirs + offset
      az: {from: acc_up, offset: -9.81}

Our columns are those of q2q_model.flights.tables.flight_table, SI, without the vehicle's name; in a table of
several vehicles, `<vehicle>_` is before theirs, and so before ours. FIRMWARE has the log variables of the
Crazyflie's firmware and of the logs of aerorobotics/neural-swarm.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.nearest_name import name_hint
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_model.vehicle.thrust_map import GRAM_FORCE, PWM_FULL


@dataclass(frozen=True, slots=True)
class SourceColumn:
    """Column that one of ours is made of: scale * column + offset."""

    name: str
    scale: float = 1.0
    offset: float = 0.0


ColumnMap = Mapping[str, tuple[SourceColumn, ...]]
"""Column of ours -> its possible sources, the first present one counts."""


def _of(prefix: str, fields: Mapping[str, str], scale: float = 1.0) -> dict[str, SourceColumn]:
    return {ours: SourceColumn(f"{prefix}.{theirs}", scale) for ours, theirs in fields.items()}


def _joined(*maps: Mapping[str, SourceColumn]) -> ColumnMap:
    names = dict.fromkeys(ours for one in maps for ours in one)
    return {ours: tuple(one[ours] for one in maps if ours in one) for ours in names}


_POS, _VEL, _ACC = ({p + axis: p + axis for axis in "xyz"} for p in ("", "v", "a"))
_RATES = {"wp": "rateRoll", "wq": "ratePitch", "wr": "rateYaw"}
_GYRO = {"wp": "x", "wq": "y", "wr": "z"}
_REF = {f"{p}{axis}ref": f"{p}{axis}" for p in ("", "v") for axis in "xyz"}
_MOTORS = {f"pwm{k}": f"m{k}" for k in range(1, 5)}
FIRMWARE: ColumnMap = _joined(
    _of("stateEstimate", {**_POS, **_VEL, "qx": "qx", "qy": "qy", "qz": "qz", "qw": "qw"}),
    _of("stateEstimate", _ACC, GRAVITY),  # in g, gravity taken off
    _of("stateEstimateZ", {**_POS, **_VEL, "ax": "ax", "ay": "ay"}, 1e-3),
    {"az": SourceColumn("stateEstimateZ.az", 1e-3, -GRAVITY)},  # with gravity
    _of("gyro", _GYRO, math.radians(1.0)),
    _of("stateEstimateZ", _RATES, 1e-3),
    _of("ctrltarget", _REF),
    _of("ctrltargetZ", _REF, 1e-3),
    _of("motor", _MOTORS, 1.0 / PWM_FULL),
    _of("pwm", {ours: f"{theirs}_pwm" for ours, theirs in _MOTORS.items()}, 1.0 / PWM_FULL),
    {"vbat": SourceColumn("pm.vbat")},
    {"vbat": SourceColumn("pm.vbatMV", 1e-3)},
    {"thrust_cmd": SourceColumn("motor.thrust")},
    {"fa_ff": SourceColumn("ctrlFa.Faz", GRAM_FORCE)},
)
"""Log variables of the firmware (units: q2q_sim.crtp.tables.log_toc), and of aerorobotics/neural-swarm."""


def load_column_map(path: Path) -> ColumnMap:
    """Return the map in a YAML file.

    Raises:
        ValueError: the file is no such map; the message names the column.
    """
    document = from_plain(dict[str, object], load_yaml(path), str(path))
    columns = from_plain(dict[str, object], document.get("columns", {}), f"{path}: columns")
    if not columns:
        raise ValueError(f"{path} has no `columns`: give some, such as columns: {{x: stateEstimate.x}}")
    return {ours: (_source(value, f"{path}: columns.{ours}"),) for ours, value in columns.items()}


@dataclass(frozen=True, slots=True)
class _Source:
    from_: Annotated[str, "the name of a column"]
    scale: float = 1.0
    offset: float = 0.0


def _source(value: object, where: str) -> SourceColumn:
    given = from_plain(_Source, value if isinstance(value, Mapping) else {"from": value}, where)
    return SourceColumn(given.from_, given.scale, given.offset)


def map_columns(columns: Mapping[str, Array], chosen: ColumnMap) -> dict[str, Array]:
    """Return our columns, each from the first of its sources that is there."""
    found = {}
    for ours, sources in chosen.items():
        present = next((one for one in sources if one.name in columns), None)
        if present is not None:
            found[ours] = present.scale * columns[present.name] + present.offset
    return found


def mapped_table(columns: Mapping[str, Array], chosen: ColumnMap) -> dict[str, Array]:
    """Return the columns of a table, and ours for each vehicle.

    A source is a whole name in the table or, where there is none, what follows `<vehicle>_`.

    Raises:
        ValueError: the table has no column of a source.
    """
    plain = {ours: of for ours, of in chosen.items() if any(one.name in columns for one in of)}
    prefixed = {ours: of for ours, of in chosen.items() if ours not in plain}
    names = [one.name for of in prefixed.values() for one in of]
    require_sources(prefixed, [name for name in names if _prefixes(columns, [name])], _all_names(columns))
    found = dict(columns) | map_columns(columns, plain)
    for prefix in _prefixes(columns, names):
        own = {name.removeprefix(prefix): columns[name] for name in columns if name.startswith(prefix)}
        found |= {f"{prefix}{ours}": values for ours, values in map_columns(own, prefixed).items()}
    return found


def require_sources(chosen: ColumnMap, present: Collection[str], known: Collection[str]) -> None:
    """Raise ValueError with the nearest known name if no source of a column is present."""
    for ours, sources in chosen.items():
        if not any(one.name in present for one in sources):
            given = " or ".join(one.name for one in sources)
            raise ValueError(f"{ours} of the column map: no column {given}; {name_hint(given, known)}")


def _prefixes(columns: Collection[str], sources: Collection[str]) -> list[str]:
    """Return `<vehicle>_` of the columns that end in a source, without those of vectors of a vehicle."""
    found = {
        name.removesuffix(source): None
        for name in columns
        for source in sources
        if name.endswith(f"_{source}")
    }
    return [one for one in found if not any(one != other and one.startswith(other) for other in found)]


def _all_names(columns: Collection[str]) -> list[str]:
    """Return the names in a table, whole and without a vehicle."""
    return sorted({*columns, *(name.split("_", 1)[-1] for name in columns)})
