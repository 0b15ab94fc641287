"""Topics of a recording: what a user may ask for, and which of it never came."""

from collections import Counter
from collections.abc import Collection, Mapping

from q2q_model.bag.storage.definitions import definition_of, jazzy_types
from q2q_sim.flight_bag.topics import TYPE_NAMES

HEADER = "std_msgs/msg/Header"


def recorded_types(topics: Collection[str], extra: Collection[str], *, by_header: bool) -> dict[str, str]:
    """Return the topics to record and their message types: `topics` of q2q, none are all, and `extra`.

    A topic of q2q may begin with a slash; it is that of no namespace then.

    Raises:
        ValueError: an unknown topic or type, a topic given twice, or a message without a header though its
            stamp is asked for (`by_header`).
    """
    unknown = [topic for topic in topics if topic.removeprefix("/") not in TYPE_NAMES]
    if unknown:
        raise ValueError(f"parameter topics: no {', '.join(unknown)}; choose from {', '.join(TYPE_NAMES)}")
    further = _further(extra)
    for topic, kind in further:
        definition_of(kind)
        if by_header and not _has_header(kind):
            raise ValueError(f"parameter extra: {topic}: {kind} has no header: give stamps:=receive")
    either = {given: kind for topic, kind in TYPE_NAMES.items() for given in (topic, f"/{topic}")}
    chosen = {given: kind for given, kind in either.items() if given in topics} or dict(TYPE_NAMES)
    counts = Counter([*chosen, *(topic for topic, _ in further)])
    if repeated := ", ".join(topic for topic, count in counts.items() if count > 1):
        raise ValueError(f"parameter extra: {repeated} would be recorded twice: leave out one")
    return chosen | dict(further)


def check_distinct(full_names: Mapping[str, str]) -> None:
    """Raise ValueError if two topics to record are one; each has its full name, in its namespace."""
    given: dict[str, str] = {}
    for topic, full_name in full_names.items():
        first = given.setdefault(full_name, topic)
        if first != topic:
            both = f"{first} and {topic} are both {full_name}, which would be recorded twice"
            raise ValueError(f"{both}: leave one out of the parameters topics and extra")


def other_types_note(topic: str, kind: str, published: Collection[str]) -> str:
    """Return that a topic to record is published with other types than its `kind` only, or an empty text."""
    if not published or kind in published:
        return ""
    others = ", ".join(sorted(set(published)))
    return f"{topic} is published as {others}, not as {kind}: it is not recorded"


def silent_topics_note(asked: Collection[str], received: Collection[str]) -> str:
    """Return what a user has to know of topics without a message; empty if there is nothing.

    Args:
        asked: topics that the user has named.
        received: topics with a message.
    """
    silent = [topic for topic in asked if topic not in received]
    if received and not silent:
        return ""
    which = f"on {', '.join(silent)}" if silent else "on any topic"
    return f"no message came {which}: check that their nodes run, with these names and in this ROS_DOMAIN_ID"


def _further(extra: Collection[str]) -> list[tuple[str, str]]:
    pairs = [word.partition(":") for word in extra]
    wrong = [
        word for word, (_, colon, kind) in zip(extra, pairs, strict=True) if not colon or kind.count("/") != 2
    ]
    if wrong:
        raise ValueError(f"parameter extra: {', '.join(wrong)}; write topic:package/msg/Type")
    return [(topic, kind) for topic, _, kind in pairs]


def _has_header(kind: str) -> bool:
    """Return whether the first field of a message is its header."""
    fields = jazzy_types().fielddefs[kind][1]
    return bool(fields) and fields[0][1][1] == HEADER
