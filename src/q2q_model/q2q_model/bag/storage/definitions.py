"""Message definitions without ROS: common types from rosbags, those of q2q_msgs from their .msg files."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import RawMessage

PACKAGE = "q2q_msgs"


@lru_cache(maxsize=1)
def jazzy_types() -> Typestore:
    """Return the message types of ROS 2 Jazzy and q2q_msgs."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for path in sorted(message_folder().glob("*.msg")):
        store.register(get_types_from_msg(path.read_text(), f"{PACKAGE}/msg/{path.stem}"))
    return store


@cache
def definition_of(type_name: str) -> tuple[str, str]:
    """Return the ros2msg definition of a type and its hash (REP 2016).

    Raises BagError for a type that is neither common nor of q2q_msgs.
    """
    store = jazzy_types()
    if type_name not in store.fielddefs:
        ours = ", ".join(sorted(name for name in store.fielddefs if name.startswith(PACKAGE)))
        raise BagError(f"no definition of message type {type_name!r}; must be a common ROS type, {ours}")
    return store.generate_msgdef(type_name, ros_version=2)[0], store.hash_rihs01(type_name)


@contextmanager
def naming_message(bag: Path, found: RawMessage, type_name: str) -> Iterator[None]:
    """Raise BagError, which names the message, for whatever decoding it as this type raises."""
    try:
        yield
    except Exception as damage:  # the decoder of rosbags asserts, indexes and unpacks
        where = f"topic {found.topic} at {found.stamp_ns} ns"
        raise BagError(f"bag {bag}, {where}: no {type_name} ({damage})") from damage


def message_folder() -> Path:
    """Return the folder of the .msg files: installed by pip, in an ament prefix, or in the source tree."""
    here = Path(__file__).resolve()
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    places = [
        here.parents[2] / "msg",
        *(Path(prefix, "share", PACKAGE, "msg") for prefix in prefixes),
        *(parent / PACKAGE / "msg" for parent in here.parents),
    ]
    for place in places:
        if (place / "MocapFrame.msg").is_file():
            return place
    raise BagError("cannot find the .msg files of q2q_msgs: source scripts/env.sh, or pip install q2q again")
