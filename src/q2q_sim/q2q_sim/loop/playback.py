"""Playback of a bag: the schedule between bag time and wall time, and what can be played."""

from collections.abc import Iterable
from dataclasses import dataclass

from q2q_model.nearest_name import name_hint
from q2q_sim.loop.topics import TYPE_NAMES

TICK_TOPIC = "mocap"
"""Topic whose messages are the ticks in lockstep."""


@dataclass(frozen=True, slots=True)
class Playback:
    """Offset and rate between bag time and wall time."""

    first_ns: int
    """Bag time of the first message to play [ns]."""
    began: float
    """Wall time of the first message [s]."""
    rate: float
    """Bag seconds per wall second."""

    def due(self, stamp_ns: int) -> float:
        """Return the wall time of a message with this bag time [s]."""
        return self.began + (stamp_ns - self.first_ns) * 1e-9 / self.rate


def check_start(stamps: Iterable[int], start: float) -> None:
    """Raise ValueError if there is no message, or none from `start` [s] on; `stamps` rise [ns]."""
    left = iter(stamps)
    first = next(left, None)
    if first is None:
        raise ValueError("the bag has no message to play")
    since, begin = 0, round(start * 1e9)
    while since < begin:
        later = next(left, None)
        if later is None:
            raise ValueError(f"parameter start = {start:g} s: the bag lasts {since / 1e9:.1f} s")
        since = later - first


def check_answer(answer: str, played: Iterable[str]) -> None:
    """Raise ValueError if ticks cannot wait for a topic's answers; nothing waits for an empty one."""
    if not answer:
        return
    if answer.strip("/") not in TYPE_NAMES:
        raise ValueError(f"parameter answer = {answer!r}: no such topic; {name_hint(answer, TYPE_NAMES)}")
    topics = {topic.strip("/") for topic in played}
    if answer.strip("/") in topics:
        raise ValueError(
            f"parameter answer = {answer!r}: the bag has it and would answer itself; play only what your "
            f"nodes read, e.g. -p topics:=[{TICK_TOPIC}]"
        )
    if TICK_TOPIC not in topics:
        raise ValueError(f"parameter answer: the ticks are the messages on {TICK_TOPIC}, which is not played")
