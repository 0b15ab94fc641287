"""Message definitions stored in a bag, and whether they are those that q2q's decoders assume.

Signals are decoded by a fixed layout (q2q_model.signals.cdr), and CDR carries no field names: a message of
another definition would be decoded to wrong numbers. Fields appended by a later version are not read.
"""

import re
from functools import cache, lru_cache
from pathlib import Path

from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import FieldDesc, Typesdict
from rosbags.typesys import get_types_from_idl, get_types_from_msg

from q2q_model.bag.storage.definitions import PACKAGE, message_folder
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import Channel

IDL_MARK = "=" * 80 + "\n"
INCLUDE = re.compile(r"^#include.*$", re.MULTILINE)
"""Line of an IDL definition that names another; their text follows after further marks."""


def check_fields(bag: Path, channel: Channel) -> None:
    """Raise BagError if the bag defines a q2q_msgs type with other fields than this version of q2q.

    A definition that cannot be read is none: the bag is read by this version's. One without the type is an
    error.
    """
    if not channel.type_name.startswith(f"{PACKAGE}/"):
        return
    if not (types := _readable_types(channel.type_name, channel.definition)):
        return
    if channel.type_name not in types:
        raise BagError(
            f"bag {bag}, topic {channel.topic}: the definition of {channel.type_name} there is of "
            f"{', '.join(types)}; it must hold {channel.type_name}"
        )
    expected, given = _installed_fields(channel.type_name), _fields(types, channel.type_name)
    if given[: len(expected)] == expected:
        return
    same = next((k for k, (a, b) in enumerate(zip(given, expected, strict=False)) if a != b), len(given))
    raise BagError(
        f"bag {bag}, topic {channel.topic}: {channel.type_name} is defined there, from field {same + 1} on, "
        f"as {', '.join(given[same:]) or 'empty'}; must be {', '.join(expected[same:])}: read the bag with "
        "the version of q2q that recorded it"
    )


def own_types(bag: Path, type_name: str, definition: str) -> Typesdict:
    """Return the types in a definition; raise BagError if it cannot be read."""
    if not (types := _readable_types(type_name, definition)):
        raise BagError(f"bag {bag}: the definition of {type_name} cannot be read")
    return types


@lru_cache(maxsize=64)
def _readable_types(type_name: str, definition: str) -> Typesdict:
    """Return the types in a definition; empty if there is none that can be read."""
    try:
        if not definition.startswith(f"{IDL_MARK}IDL: "):
            return get_types_from_msg(definition, type_name) if definition else {}
        parts = [part.split("\n", 1)[1] for part in INCLUDE.sub("", definition).split(IDL_MARK)[1:]]
        return {name: one for part in parts for name, one in get_types_from_idl(part).items()}
    except Exception:  # noqa: BLE001  whatever the grammar raises
        return {}


@cache
def _installed_fields(type_name: str) -> tuple[str, ...]:
    """Return type and name of every field of a type of q2q_msgs; empty if there is no such type."""
    file = message_folder() / f"{type_name.rsplit('/', 1)[-1]}.msg"
    return _fields(get_types_from_msg(file.read_text(), type_name), type_name) if file.is_file() else ()


def _fields(types: Typesdict, type_name: str) -> tuple[str, ...]:
    return tuple(f"{_type_text(desc)} {name}" for name, desc in types[type_name][1])


def _type_text(desc: FieldDesc) -> str:
    """Return a field's type as a definition writes it, e.g. float64[]."""
    if desc[0] == Nodetype.NAME:
        return str(desc[1])
    inner, size = desc[1]
    return str(inner) if desc[0] == Nodetype.BASE else f"{_type_text(inner)}[{size or ''}]"
