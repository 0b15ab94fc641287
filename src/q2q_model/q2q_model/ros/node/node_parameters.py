"""ROS parameters declared from a Params dataclass: description, range, read-only flag, live changes."""

from collections.abc import Callable, Iterable
from dataclasses import Field, fields, replace
from fnmatch import fnmatchcase
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterNotDeclaredException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from q2q_model.nearest_name import parameter_hint
from q2q_model.tunable import LARGEST_INTEGER, ParamsClass, Tunable, tunable_of, with_overrides

P = TypeVar("P", bound=ParamsClass)

UNBOUNDED = 1.7e308
"""Bound of an unbounded FloatingPointRange, which cannot express infinity."""

_WITHHELD: WeakKeyDictionary[Node, dict[str, str]] = WeakKeyDictionary()
"""For each node, patterns of parameters that it does not declare as it is started, and what each needs."""


def declare(node: Node, params: P, prefix: str = "", *, in_flight: bool = False) -> P:
    """Declare every field of `params` as a ROS parameter under a prefix; return the user's values.

    With `in_flight`, parameters that are not read-only may change later (see `on_change`).

    Raises ValueError with parameter, value and allowed range.
    """
    values = {
        entry.name: _declared(node, params, entry, prefix, in_flight=in_flight) for entry in fields(params)
    }
    return with_overrides(params, values)


def withhold(node: Node, params: ParamsClass, needs: str, prefix: str = "") -> None:
    """Let the refusal of parameters of `params`, which the node does not declare, say what they need."""
    for entry in fields(params):
        withhold_named(node, prefix + entry.name, needs)


def withhold_named(node: Node, pattern: str, needs: str) -> None:
    """Let the refusal of parameters of a pattern (`crtp_*`), which the node lacks, say what they need."""
    _WITHHELD.setdefault(node, {})[pattern] = needs


def refuse_undeclared(nodes: Iterable[Node]) -> None:
    """Raise ValueError for a user-set parameter that no node of the process has declared.

    Call it after all declarations: ROS itself ignores a misspelt name silently.
    """
    here = list(nodes)
    known = {name for node in here for name in node.list_parameters([], 0).names}
    given = {name for node in here for name in node._parameter_overrides}  # noqa: SLF001  (rclpy has no accessor)
    withheld = [entry for node in here for entry in _WITHHELD.get(node, {}).items()]
    for name in sorted(given - known):
        for pattern, needs in withheld:
            if fnmatchcase(name, pattern):
                raise ValueError(f"parameter {name} needs {needs}")
        raise ValueError(f"no parameter {name}; {parameter_hint(name, sorted(known))}")


def name_undeclared(node: Node) -> None:
    """Answer who sets an undeclared parameter by its name and the nearest one; rclpy's reason is "[]"."""

    def checked(asked: list[Parameter]) -> list[Parameter]:
        for name in (one.name for one in asked if not node.has_parameter(one.name)):
            hint = parameter_hint(name, node.list_parameters([], 0).names)
            raise ParameterNotDeclaredException(f"{name}; {hint}")
        return asked

    node.add_pre_set_parameters_callback(checked)


def on_change(node: Node, params: P, apply: Callable[[P], None], prefix: str = "") -> None:
    """Call `apply` with the new Params whenever parameters of `params` are set in flight, and log them."""
    current = [params]
    known = {prefix + entry.name: entry.name for entry in fields(params)}

    def changed(updates: list[Parameter]) -> SetParametersResult:
        overrides = {known[one.name]: _plain(one.value) for one in updates if one.name in known}
        if not overrides:  # rclpy calls it for every parameter of the node, also when one is declared
            return SetParametersResult(successful=True)
        try:
            asked = with_overrides(current[0], overrides)
            apply(asked)
        except ValueError as refusal:
            return SetParametersResult(successful=False, reason=str(refusal))
        for name, value in overrides.items():
            if value != (before := getattr(current[0], name)):
                node.get_logger().info(f"{prefix}{name} changed from {before} to {value}")
        current[0] = asked
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(changed)


def _declared(node: Node, params: ParamsClass, entry: Field[Any], prefix: str, *, in_flight: bool) -> Any:  # noqa: ANN401
    default, name = getattr(params, entry.name), prefix + entry.name
    spec = tunable_of(entry)
    spec = spec if in_flight else replace(spec, read_only=True)
    plain = list(default) if isinstance(default, tuple) else default
    if plain == []:
        plain = Parameter.Type.STRING_ARRAY
    try:
        value = node.declare_parameter(name, plain, _descriptor(spec, default)).value
    except InvalidParameterValueException as refusal:
        given = str(refusal).partition(" Reason")[0]
        raise ValueError(f"parameter {name} must be {spec.allowed}; {given}") from refusal
    except InvalidParameterTypeException as refusal:
        raise ValueError(_wrong_type(node, name, default)) from refusal
    if value is not None:
        return _plain(value)
    # rclpy declares no empty list of strings, only an unset one, and then gives no other parameter
    node._parameters[name] = Parameter(name, Parameter.Type.STRING_ARRAY, [])  # noqa: SLF001
    return default


def _wrong_type(node: Node, name: str, default: Any) -> str:  # noqa: ANN401
    given = node._parameter_overrides[name]  # noqa: SLF001  (rclpy has no accessor)
    example = default
    if isinstance(default, tuple):
        one_or_more = [given.value] if isinstance(given.value, bool | int | float | str) else given.value
        example = list(default) or [str(one) for one in one_or_more if one != ""]
    elif isinstance(default, float) and given.type_ is Parameter.Type.INTEGER:
        example = float(given.value)
    return f"parameter {name} = {given.value!r} has the wrong type; give a value like {example!r}"


def _plain(value: Any) -> Any:  # noqa: ANN401
    return tuple(value) if not isinstance(value, bool | int | float | str) else value


def _descriptor(spec: Tunable, default: Any) -> ParameterDescriptor:  # noqa: ANN401
    unit = f" [{spec.unit}]" if spec.unit else ""
    made = ParameterDescriptor(description=spec.description + unit, read_only=spec.read_only)
    if isinstance(default, float) and (spec.low is not None or spec.high is not None):
        low = -UNBOUNDED if spec.low is None else float(spec.low)
        high = UNBOUNDED if spec.high is None else float(spec.high)
        made.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif isinstance(default, int) and not isinstance(default, bool) and spec.low is not None:
        high_int = LARGEST_INTEGER if spec.high is None else int(spec.high)
        made.integer_range = [IntegerRange(from_value=int(spec.low), to_value=high_int)]
    made.additional_constraints = ", ".join(spec.choices)
    return made
