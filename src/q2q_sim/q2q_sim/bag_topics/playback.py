"""Playback of a bag: the schedule between bag time and wall time, and what can be played."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from q2q_model.nearest_name import name_hint
from q2q_sim.bag_topics.topics import TYPE_NAMES

TICK_TOPIC = "mocap"
"""Topic whose messages are the ticks in lockstep."""
PAUSE_S = 1.0
"""Time without a look for due messages [s] that is a pause, not to be caught up in a burst."""
MOMENT_S = 1.0
"""Round of a loop over a bag without duration [s], such as one of a single plan."""


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

    def after_pause(self, pause: float) -> "Playback":
        """Return the playback that goes on where it was before a pause [s], as of a stopped process."""
        return replace(self, began=self.began + pause)

    def next_round(self, last_ns: int, now: float) -> "Playback":
        """Return the next round of a loop whose last message has this bag time [ns]."""
        return replace(self, began=now + (MOMENT_S if last_ns <= self.first_ns else 0.0))


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


def played_tick_topics(played: Iterable[str], answer: str) -> set[str]:
    """Return the topics of ticks: that in the namespace of `answer`, or where there is none, in any."""
    ticks = {topic for topic in played if topic.rpartition("/")[2] == TICK_TOPIC}
    room = answer.strip("/").rpartition("/")[0]
    beside = {topic for topic in ticks if topic.strip("/").rpartition("/")[0] == room}
    return (answer and beside) or ticks


def answer_type(answer: str) -> str:
    """Return the message type of the topic of answers; empty if it is none of a flight."""
    return TYPE_NAMES.get(answer.rstrip("/").rpartition("/")[2], "")


def check_answer(answer: str, played: Iterable[str]) -> None:
    """Raise ValueError if ticks cannot wait for a topic's answers; nothing waits for an empty one."""
    if not answer:
        return
    if not answer_type(answer):
        raise ValueError(f"parameter answer = {answer!r}: no such topic; {name_hint(answer, TYPE_NAMES)}")
    topics = {topic.strip("/") for topic in played}
    if answer.strip("/") in topics:
        raise ValueError(
            f"parameter answer = {answer!r}: the bag has it and would answer itself; play only what your "
            f"nodes read, e.g. -p topics:=[{TICK_TOPIC}]"
        )
    if not played_tick_topics(topics, answer):
        raise ValueError(f"parameter answer: the ticks are the messages on {TICK_TOPIC}, which is not played")
