"""Parameters of the blocks of a flight, with the values that a scenario gives in place of the defaults."""

from collections.abc import Mapping
from typing import TypeVar

from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.pid.pid_params import PidParams
from q2q_model.documents.numpy_values import without_numpy
from q2q_model.documents.shown_value import shown_value
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.nearest_name import name_hint
from q2q_model.tunable import ParameterValue, ParamsClass, with_overrides
from q2q_planner.online.potential_field import PotentialFieldParams
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_sim.scenarios.room_profiles import Overrides

P = TypeVar("P", bound=ParamsClass)

BLOCKS: dict[str, ParamsClass] = {
    "mocap_filter": MocapFilterParams(),
    "replanner": PotentialFieldParams(),
    "safe_replanner": SafeReplannerParams(),
    "pid": PidParams(),
    "mpc": MpcParams(),
}
"""Blocks whose parameters a scenario may override."""


def block_params(block: str, default: P, overrides: Overrides) -> P:
    """Return a block's parameters with a scenario's overrides."""
    return override_params(default, overrides.get(block, {}), block)


def override_params(params: P, values: Mapping[str, object], where: str) -> P:
    """Return `params` with values from a document.

    Raises:
        ValueError: an unknown parameter, a value of another type, or one out of bounds.
    """
    return with_overrides(params, _values(params, values, where))


def merge_overrides(room: Overrides, own: Mapping[str, Mapping[str, object]]) -> Overrides:
    """Return the overrides of a room with those of a document, which come first.

    Raises:
        ValueError: an unknown block, or a value of another type.
    """
    blocks = {block: _values(_block(block), values, f"overrides.{block}") for block, values in own.items()}
    return {block: {**room.get(block, {}), **blocks.get(block, {})} for block in sorted({*room, *blocks})}


def check_overrides(overrides: Overrides) -> None:
    """Raise ValueError for an unknown block or parameter, or a value that is not allowed."""
    for block, values in overrides.items():
        override_params(_block(block), values, block)


def _block(name: str) -> ParamsClass:
    if name not in BLOCKS:
        raise ValueError(f"overrides: unknown block {name!r}; {name_hint(name, BLOCKS)}")
    return BLOCKS[name]


def _values(params: ParamsClass, values: Mapping[str, object], where: str) -> dict[str, ParameterValue]:
    """Return a document's values as parameters; `with_overrides` refuses unknown names."""
    given = {key: without_numpy(value) for key, value in values.items()}
    return {key: _value(value, getattr(params, key, value), f"{where}.{key}") for key, value in given.items()}


def _value(value: object, default: object, where: str) -> ParameterValue:
    """Return a document's value in the type of a parameter: an integer as float, a list as tuple."""
    if isinstance(default, tuple | list) and isinstance(value, list | tuple):
        return tuple(_number(one, where) for one in value)
    if isinstance(default, float):
        return _number(value, where)
    if isinstance(value, bool | int | str) and type(value) is type(default):
        return value
    raise ValueError(f"{where} = {shown_value(value)}; must be a {type(default).__name__}")


def _number(value: object, where: str) -> float:
    value = without_numpy(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{where} = {shown_value(value)}; must be a number")  # noqa: TRY004  a bad document, not a bad call
    try:
        return float(value)
    except OverflowError as error:  # an integer beyond 1e308
        raise ValueError(f"{where} = {shown_value(value)}; must be a finite number") from error
