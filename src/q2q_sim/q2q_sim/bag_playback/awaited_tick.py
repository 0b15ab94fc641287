"""Playback tick by tick: which messages are ticks, what answers them, and the tick that waits for it."""

from collections.abc import Iterable, Sequence

from q2q_model.bag import RawMessage
from q2q_model.nearest_name import name_hint
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_sim.bag_playback.tick_messages import BagTick
from q2q_sim.flight_bag.topics import TYPE_NAMES
from q2q_sim.simulator.resend_timer import ResendTimer

TICK_TOPIC = "mocap"
"""Topic whose messages are the ticks in lockstep."""
RESEND_PERIOD_S = 2.0
"""Time after which an unanswered tick is played again [s]."""


class AwaitedTick:
    """Tick that was played and waits for its answer; none before the first and after the last."""

    def __init__(self) -> None:
        self.awaited: RawMessage | None = None
        self._stamped: Sequence[RawMessage] = ()
        self._resend = ResendTimer(period_s=RESEND_PERIOD_S, timeout_s=float("inf"))

    def begin(self, now: float, played: BagTick) -> None:
        """Wait for the answer to a tick that is played at wall time now [s]; for none if it is no tick."""
        self.awaited, self._stamped = played.tick, played.stamped
        self._resend.begin(now)

    def is_answered_by(self, message: bytes) -> bool:
        """Return whether a message answers the tick: whether both have one stamp.

        Raises:
            ValueError: the message has no header.
        """
        stamp_ns = header_stamp_ns(message)
        return self.awaited is not None and stamp_ns == header_stamp_ns(self.awaited.data)

    def unanswered(self, now: float) -> Sequence[RawMessage]:
        """Return the messages of the tick if they are to be played again at wall time now [s]."""
        return self._stamped if self.awaited is not None and self._resend.poll_resend(now) else ()


def played_tick_topics(played: Iterable[str], awaited: str) -> set[str]:
    """Return the topics of ticks: that in the namespace of `awaited`, or where there is none, in any."""
    ticks = {topic for topic in played if topic.rpartition("/")[2] == TICK_TOPIC}
    room = awaited.strip("/").rpartition("/")[0]
    beside = {topic for topic in ticks if topic.strip("/").rpartition("/")[0] == room}
    return (awaited and beside) or ticks


def awaited_type(awaited: str) -> str:
    """Return the message type of the topic of answers; empty if it is none of a flight."""
    return TYPE_NAMES.get(awaited.rstrip("/").rpartition("/")[2], "")


def check_awaited(awaited: str, played: Iterable[str]) -> None:
    """Raise ValueError if ticks cannot wait for a topic's answers; nothing waits for an empty one."""
    if not awaited:
        return
    if not awaited_type(awaited):
        raise ValueError(f"parameter wait_for = {awaited!r}: no such topic; {name_hint(awaited, TYPE_NAMES)}")
    topics = {topic.strip("/") for topic in played}
    if awaited.strip("/") in topics:
        raise ValueError(
            f"parameter wait_for = {awaited!r}: the bag has it, so playback would answer itself; play only "
            f"what your nodes read, e.g. -p topics:=[{TICK_TOPIC}]"
        )
    if not played_tick_topics(topics, awaited):
        raise ValueError(f"parameter wait_for: ticks are messages on {TICK_TOPIC}, which is not played")
