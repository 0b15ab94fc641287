"""Parameters as frozen dataclass fields with unit, description and bounds.

A block's parameters are the fields of one frozen `...Params` dataclass next to the block. The same fields are
the node's ROS parameters (declared by q2q_model.ros.node.node_parameters), the keys that a scenario or YAML
file may override, and the rows of the documentation. Allowed field types: bool, int, float, str,
tuple[float, ...], tuple[str, ...].
"""

from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields, replace
from numbers import Real
from typing import Any, ClassVar, Protocol, TypeVar

from q2q_model.nearest_name import parameter_hint

LARGEST_INTEGER = 2**63 - 1
"""Largest integer of a ROS parameter (rcl_interfaces/ParameterValue: int64)."""

ParameterValue = bool | int | float | str | tuple[float, ...] | tuple[str, ...]


class ParamsClass(Protocol):
    """Any dataclass of parameters."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


P = TypeVar("P", bound=ParamsClass)
T = TypeVar("T", bound=ParameterValue)


@dataclass(frozen=True, slots=True)
class Tunable:
    """Description and bounds of a parameter."""

    description: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False
    """Settable only at node start."""

    @property
    def allowed(self) -> str:
        """Return the allowed values as text that follows "must be"."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if self.low is None or self.high is None:
            bound = f"at least {self.low}" if self.high is None else f"at most {self.high}"
            return f"{bound} {self.unit}".rstrip() if self.low is not self.high else "a number"
        return f"in [{self.low}, {self.high}] {self.unit}".rstrip()


class OutOfBoundsError(ValueError):
    """Error for a value that a parameter may not have."""

    def __init__(self, owner: str, name: str, rest: str) -> None:
        """Word the error of a field of the class `owner`; `rest` says its value and what is allowed."""
        super().__init__(owner, name, rest)
        self.owner, self.name, self.rest = owner, name, rest

    def __str__(self) -> str:
        """Return class, field, value and what is allowed."""
        return f"{self.owner}.{self.name} = {self.rest}"


def tunable(default: T, description: str, **rest: Any) -> T:  # noqa: ANN401
    """Return a dataclass field that declares a parameter; `rest` are the other fields of Tunable.

    Typed as its default so that `gain: float = tunable(1.0, ...)` type-checks.
    """
    made: T = field(default=default, metadata={"tunable": Tunable(description, **rest)})
    return made


def tunable_of(entry: Field[Any]) -> Tunable:
    """Return the Tunable of a dataclass field."""
    found = entry.metadata.get("tunable")
    if not isinstance(found, Tunable):
        raise TypeError(f"field {entry.name} is not a parameter: declare it with tunable(...)")
    return found


def check_bounds(params: ParamsClass) -> None:
    """Raise OutOfBoundsError with field, value and range of the first violation; for `__post_init__`."""
    for entry in fields(params):
        value = getattr(params, entry.name)
        _check_kind(type(params).__name__, entry, value)
        _check(type(params).__name__, entry.name, value, tunable_of(entry))


def with_overrides(params: P, overrides: Mapping[str, ParameterValue]) -> P:
    """Return `params` with some fields replaced.

    Raises ValueError for an unknown key (with the closest known one) or a value out of bounds.
    """
    known = [entry.name for entry in fields(params)]
    for key in overrides:
        if key not in known:
            hint = parameter_hint(key, known)
            raise ValueError(f"{type(params).__name__} has no parameter {key!r}; {hint}")
    return replace(params, **overrides)


def _check_kind(owner: str, entry: Field[Any], value: object) -> None:
    """Raise OutOfBoundsError for a text, truth value, array or list where the default is a number."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if isinstance(entry.default, Real) and not isinstance(entry.default, bool) and not is_number:
        allowed = tunable_of(entry).allowed
        said = allowed if allowed == "a number" else f"a number {allowed}"
        raise OutOfBoundsError(owner, entry.name, f"{value!r}; must be {said}")


def _check(owner: str, name: str, value: ParameterValue, spec: Tunable) -> None:
    if spec.choices and value not in spec.choices:
        raise OutOfBoundsError(owner, name, f"{value!r}; must be {spec.allowed}")
    if isinstance(value, bool | str):
        return
    for number in value if isinstance(value, tuple) else (value,):
        if isinstance(number, str):
            if not number.strip():
                raise OutOfBoundsError(owner, name, f"{value}; texts must not be empty: leave out {number!r}")
            continue
        low = -float("inf") if spec.low is None else spec.low
        high = float("inf") if spec.high is None else spec.high
        if not low <= number <= high:
            raise OutOfBoundsError(owner, name, f"{value}; must be {spec.allowed}")
