"""What is wrong with the topics of poses: motion capture has other names, or the server cannot read them.

Crazyswarm2's server requests a deadline of 1 / `poses_qos_deadline` of its server.yaml (100 Hz unless
configured otherwise). DDS connects a reader only to a writer that offers no longer deadline than it requests.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from q2q_model.counted import listed
from q2q_model.signals.stamps import NANOSECONDS, TICK_NS
from q2q_model.signals.values import Names

DEADLINE_NS = TICK_NS
"""Deadline that is offered to readers of filtered poses [ns]."""


@dataclass(frozen=True, slots=True)
class PoseReader:
    """Reader of the filtered poses."""

    node: str
    deadline_ns: int
    """Requested deadline [ns]; 0 means none."""


def readers_refusal(topic: str, readers: Sequence[PoseReader]) -> str:
    """Return why the server gets no filtered poses from a topic, and what to do; empty if it does."""
    if not readers:
        return f"no node reads {topic}: start Crazyswarm2's server with its topic poses remapped to {topic}"
    for one in readers:
        if 0 < one.deadline_ns < DEADLINE_NS:
            return (
                f"no pose of {topic} reaches {one.node}, which requires a deadline of "
                f"{1e-6 * one.deadline_ns:g} ms: {1e-6 * DEADLINE_NS:g} ms is offered; set "
                f"poses_qos_deadline in server.yaml to {NANOSECONDS / DEADLINE_NS:g} Hz or less"
            )
    return ""


class PoseNames:
    """Vehicles that were never in the poses of motion capture, and other names that are."""

    def __init__(self, topic: str, vehicles: Names) -> None:
        """Begin without a pose."""
        self._topic, self._vehicles = topic, vehicles
        self._unseen = vehicles
        self._others: Names = ()
        self._told = {""}

    def take(self, names: Sequence[str]) -> None:
        """Take the names in a message."""
        if self._unseen and names:
            self._unseen = tuple(name for name in self._unseen if name not in names)
            self._others = tuple(name for name in dict.fromkeys(names) if name not in self._vehicles)

    @property
    def mismatch(self) -> str:
        """Return which names the last poses have in place of vehicles that none ever had; empty if none."""
        if not (self._unseen and self._others):
            return ""
        names = f"{self._topic} has {listed(self._others)}, none of {listed(self._unseen)}"
        return f"{names}: name the bodies in motion capture like the vehicles"

    def new_mismatch(self) -> str:
        """Return the mismatch if it was not returned before; empty otherwise."""
        found = "" if self.mismatch in self._told else self.mismatch
        self._told.add(found)
        return found
