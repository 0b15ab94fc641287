"""Cooperative scheduler: threads of a program, one at a time, and the clock that they see.

A thread keeps the turn until it waits. When all wait, time advances to the next deadline or the next tick of
the room, whichever is first, and the thread that waited last flies the tick. The first thread in the order of
waiting whose condition holds, or whose deadline has come, takes the turn. The order of all events is
therefore the same on any machine, and computing takes no time.

A thread that computes for long without waiting has its turn taken by the main thread (spend_for_holder). It
goes on computing, as Python threads cannot be stopped, and takes its turn again at its next call (resume).

Python runs handlers of signals in the main thread, whoever has the turn. They run in it when it has the turn,
and end its waiting, as they end a sleep of Python.
"""

import _thread
import math
from collections.abc import Callable
from dataclasses import dataclass, field

Gate = _thread.LockType


def _closed_gate() -> Gate:
    gate = _thread.allocate_lock()
    gate.acquire()
    return gate


@dataclass(slots=True, eq=False)
class _Waiting:
    """Thread that waits for its turn."""

    ready: Callable[[], bool]
    until: float
    """Deadline [s]."""
    thread: int = 0
    """Its identifier; 0 if it has not started."""
    gate: Gate = field(default_factory=_closed_gate)


def never() -> bool:
    """Return False: the condition of a thread that waits for its deadline only."""
    return False


def always() -> bool:
    """Return True: the condition of a thread that only lets others go first."""
    return True


class CooperativeScheduler:
    """Scheduler of the threads of a program that share a clock with a room; one has the turn."""

    def __init__(self, fly: Callable[[], None], tick: float) -> None:
        """Start the clock at 0; `fly` advances the room by one tick [s]. The main thread has the turn."""
        self.now = 0.0
        """Time [s]."""
        self.handing_on = False
        """Whether a thread is looking for the next one, or flying."""
        self.given = 0
        """Number of turns given up."""
        self.holder = _thread.get_ident()
        """Thread that has the turn."""
        self._fly = fly
        self._tick, self._ticks = tick, 0
        self._waiting: list[_Waiting] = []
        self._main = self.holder
        self._owed: dict[int, Gate] = {}
        """Gates of threads whose turn was taken while they computed."""
        self._deciding = _thread.allocate_lock()
        """Held while it is decided whether a turn is given up or taken."""
        self._signals: list[Callable[[], object]] = []
        """Handlers of signals that wait for the main thread's turn."""
        self._later: list[Callable[[], object]] = []
        """Those that do not end its waiting."""

    def wait(self, ready: Callable[[], bool], until: float = math.inf) -> bool:
        """Give up the turn until a condition holds or a time [s] has come; return whether it holds."""
        self.claim()
        self._hand_on(ready, until)
        if self.holder == self._main:
            self._signals += self._later
            self._later.clear()
        while self._signals and self.holder == self._main:
            self._signals.pop(0)()
            if not ready() and self.now < until:
                self._hand_on(ready, until)
        return ready()

    def handle(self, signal: Callable[[], object]) -> None:
        """Run a handler of a signal, in the main thread: now if that has the turn, or else when it has."""
        if self.holder == self._main and not self.is_deciding:
            signal()
        else:
            self._signals.append(signal)

    def handle_next(self, signal: Callable[[], object]) -> None:
        """Run a handler in the main thread when its present wait is over."""
        self._later.append(signal)

    def sleep(self, seconds: float) -> None:
        """Give up the turn for a time [s]."""
        self.wait(never, self.now + max(seconds, 0.0))

    def enter(self) -> Gate:
        """Return the gate of a new thread, which takes its turn before it does anything."""
        self.resume()
        mine = _Waiting(always, math.inf)
        self._waiting.append(mine)
        return mine.gate

    def take(self, gate: Gate) -> None:
        """Wait at a gate until the calling thread has the turn."""
        gate.acquire()
        self.holder = _thread.get_ident()

    def leave(self) -> None:
        """Give up the turn; a thread that ends calls this last."""
        self.handing_on = True
        self.given += 1
        while (chosen := self._next()) is None:
            self._advance()
        self._waiting.remove(chosen)
        self.holder = chosen.thread
        self.handing_on = False
        chosen.gate.release()

    def spend(self, seconds: float) -> None:
        """Advance the clock of the thread that has the turn; others go first where they are due."""
        self.claim()
        after = self.now + seconds
        if after < self._due():
            self.now = after
            self.handing_on = False
        else:
            self.wait(never, after)

    @property
    def is_deciding(self) -> bool:
        """Return whether a thread is about to give up its turn, or to lose it."""
        return self.handing_on or self._deciding.locked()

    @property
    def computes_on(self) -> bool:
        """Return whether the thread that has the turn has computed since its turn was taken."""
        return self.holder in self._owed

    def spend_for_holder(self, seconds: float) -> None:
        """Spend time [s] for the thread that has the turn and computes, by the main thread, which waits."""
        if not self._deciding.acquire(blocking=False):
            return  # the holder is about to give up its turn
        try:
            if self.handing_on:
                return
            self.handing_on = True
            mine = _Waiting(never, self.now + seconds, self.holder)
            self._owed[self.holder] = mine.gate
        finally:
            self._deciding.release()
        self._waiting.append(mine)
        self.leave()

    def claim(self) -> None:
        """Keep the turn until the calling thread gives it up; wait for it first if it was taken.

        Not from a handler of a signal while `is_deciding`: it may have interrupted this.
        """
        while True:
            with self._deciding:
                gate = self._owed.pop(_thread.get_ident(), None)
                if gate is None:
                    self.handing_on = True
                    return
            self.take(gate)

    def resume(self) -> None:
        """Wait for the turn of the calling thread if it was taken while it computed."""
        gate = self._owed.pop(_thread.get_ident(), None) if self._owed else None
        if gate is not None:
            self.take(gate)

    def _hand_on(self, ready: Callable[[], bool], until: float) -> None:
        """Give up the turn and take it again."""
        self.handing_on = True
        mine = _Waiting(ready, until, _thread.get_ident())
        self._waiting.append(mine)
        self.leave()
        self.take(mine.gate)

    def _next(self) -> _Waiting | None:
        for one in self._waiting:
            signalled = bool(self._signals) and one.thread == self._main
            if one.until <= self.now or signalled or one.ready():
                return one
        return None

    def _due(self) -> float:
        deadline = min((one.until for one in self._waiting), default=math.inf)
        return min(deadline, (self._ticks + 1) * self._tick)

    def _advance(self) -> None:
        self.now = self._due()
        if self.now >= (self._ticks + 1) * self._tick:
            self._ticks += 1
            self._fly()
