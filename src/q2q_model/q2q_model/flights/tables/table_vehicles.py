"""Vehicles of a table, by the names of its columns.

A vehicle is a prefix with `_x`, `_y` and `_z`, or `cf1` for a table with plain `x`, `y` and `z`. Other
vectors have such columns too:

| columns | read as |
|---|---|
| x y z, gyro_x gyro_y gyro_z | one vehicle, `gyro_x` in its log |
| cf1_x cf1_y cf1_z, cf1_est_x cf1_est_y cf1_est_z | one vehicle, `est_x` in its log |
| x y z or cf1_x cf1_y cf1_z, and a prefix as in the rows above that may be a vehicle | refused |

A prefix may be a vehicle if it ends in a number (`cf2`, `drone_2`), or has attitude, velocity, reference or
thrust as well.
"""

from collections.abc import Collection

from q2q_model.signals.vehicle_name import check_vehicle_name

LONE_VEHICLE = "cf1"
AXES = ("x", "y", "z")
ESTIMATE = "est"
"""Prefix of the positions estimated onboard, of a table of one vehicle."""


def vehicle_prefixes(columns: Collection[str], carried: Collection[str]) -> dict[str, str]:
    """Return vehicle -> what the names of its columns begin with, in the order of the table.

    Args:
        columns: names of the columns.
        carried: columns of a vehicle, without its name, that are in signals.

    Raises:
        ValueError: there is no vehicle, or none with a name that vehicles may have, or two readings are
            possible.
    """
    placed = [name for name in _before_x(columns) if all(f"{name}_{axis}" in columns for axis in AXES)]
    if all(axis in columns for axis in AXES):
        _refuse_vehicles(placed, columns, carried, "x, y, z")
        return {LONE_VEHICLE: ""}
    found = {}
    for name in placed:
        owner = next((other for other in placed if _is_vector_of(name, other)), None)
        if owner is None:
            _check_name(name)
            found[name] = f"{name}_"
        else:
            _refuse_vehicles([name], columns, carried, f"{owner}_x, {owner}_y, {owner}_z")
    if not found:
        raise ValueError(
            f"the table has neither x, y, z nor <vehicle>_x, _y, _z; it has {', '.join(columns)}"
        )
    return found


def _is_vector_of(name: str, other: str) -> bool:
    """Return whether a prefix continues another one after the end of a word, as cf1_est and cf1.gyro."""
    return name.startswith(other) and len(name) > len(other) and not name[len(other)].isalnum()


def _own_columns(name: str, columns: Collection[str], carried: Collection[str]) -> list[str]:
    return sorted(one for one in set(carried) - set(AXES) if f"{name}_{one}" in columns)


def _may_be_vehicle(name: str, columns: Collection[str], carried: Collection[str]) -> bool:
    return name[-1].isdigit() or bool(_own_columns(name, columns, carried))


def _check_name(name: str) -> None:
    """Raise ValueError for what a column begins with if it can be no vehicle's name."""
    try:
        check_vehicle_name(name)
    except ValueError as wrong:
        raise ValueError(
            f"{wrong}: rename its columns, as in cf1_x, or leave them out if it is none"
        ) from wrong


def _before_x(columns: Collection[str]) -> list[str]:
    return [
        before
        for name in columns
        if name.endswith("_x") and (before := name.removesuffix("_x")) not in {"", ESTIMATE}
    ]


def _refuse_vehicles(
    placed: Collection[str], columns: Collection[str], carried: Collection[str], beside: str
) -> None:
    """Raise ValueError if one of these prefixes may be a vehicle next to other positions."""
    for name in placed:
        if _may_be_vehicle(name, columns, carried):
            own = _own_columns(name, columns, carried)
            shown = ", ".join(f"{name}_{one}" for one in (*AXES, *own[:1]))
            raise ValueError(
                f"{name} may be a vehicle or a vector of another one: the table has {beside} and {shown}; "
                "rename the columns of one of them"
            )
