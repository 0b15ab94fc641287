"""Parameters that a topic, a service or another parameter of a node requires, by its start configurations."""

from collections.abc import Hashable, Iterable, Sequence
from typing import TypeVar

from q2q_model.tunable import ParameterValue
from q2q_sim.ros.node_configurations import ANY_BUT, Configuration

Part = TypeVar("Part", bound=Hashable)


def required_parameters(found: Sequence[Iterable[Part]], chosen: Sequence[Configuration]) -> dict[Part, str]:
    """Return every part of an interface with the parameters that it requires; empty text for none.

    Args:
        found: parts of the interface in each configuration.
        chosen: the configurations.
    """
    owners: dict[Part, list[Configuration]] = {}
    for parts, configuration in zip(found, chosen, strict=True):
        for part in dict.fromkeys(parts):
            owners.setdefault(part, []).append(configuration)
    return {part: _distinction(having, chosen) for part, having in owners.items()}


def _distinction(having: Sequence[Configuration], chosen: Sequence[Configuration]) -> str:
    """Return the parameters shared by these configurations and no other; empty if there is no other."""
    lacking = [configuration for configuration in chosen if configuration not in having]
    if not lacking:
        return ""
    shared = {key: value for key, value in having[0].items() if all(one.get(key) == value for one in having)}
    distinct = {key: value for key, value in shared.items() if all(one.get(key) != value for one in lacking)}
    return ", ".join(f"`{key}`: {_words(key, value)}" for key, value in distinct.items())


def _words(key: str, value: ParameterValue) -> str:
    if key in ANY_BUT:
        return f"not {ANY_BUT[key]}"
    return str(value).lower() if isinstance(value, bool) else str(value)
