"""Flights of a program, each in a process of its own, judged by the rules.

A process is forked from the fork server, which has imported the simulator.
"""

import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from signal import strsignal
from time import monotonic

from q2q_sim.licence.flight_order import PROGRAM_TIMEOUT_S, FlightOrder
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.program_flight import fly_program, received_log
from q2q_sim.licence.program_process.simulator_errors import SimulatorFailure
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.trials import LicenceTrial
from q2q_sim.licence.rules.broken_rule import BrokenRule
from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.licence.rules.licence_rules import broken_rules
from q2q_sim.processes.fork_server import start_fork_server

DYING_S = 5.0
"""Longest time from the end of a process's output to its own [s]."""
STUCK_S = PROGRAM_TIMEOUT_S + 10.0
"""Wall time after which the process of a flight is ended from outside [s]."""


@dataclass(frozen=True, slots=True)
class FlownTrial:
    """One flight of a licence, judged."""

    trial: LicenceTrial
    findings: tuple[BrokenRule, ...]
    """In the order of time."""
    log: LicenceLog | None
    seconds: float
    """Wall time."""
    error: SimulatorFailure | None = None
    """Why the simulator failed: the program is not judged by this flight."""

    @property
    def failures(self) -> tuple[BrokenRule, ...]:
        """Return the findings that are no remarks."""
        return tuple(one for one in self.findings if not one.remark)

    @property
    def passed(self) -> bool:
        """Return whether the flight was flown and no rule was broken."""
        return not self.failures and self.error is None

    @property
    def verdict(self) -> str:
        """Return the verdict in one word."""
        if self.error is not None:
            return "ERROR"
        return "pass" if self.passed else "FAIL"

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return what was found, or how the simulator failed."""
        errors = () if self.error is None else (self.error.sentence,)
        return (*errors, *(one.sentence for one in self.findings))


@dataclass(slots=True)
class _Running:
    """Process of a flight."""

    order: FlightOrder
    process: BaseProcess
    since: float


def fly_trials(orders: Sequence[FlightOrder], options: LicenceOptions, until: float) -> Iterator[FlownTrial]:
    """Yield the flights in the order of their ends; none starts after `until` (monotonic [s])."""
    start_fork_server()
    context = get_context("forkserver")
    waiting = list(orders)
    running: dict[Connection, _Running] = {}
    try:
        while running or (waiting and monotonic() < until):
            while waiting and len(running) < options.jobs and monotonic() < until:
                order = waiting.pop(0)
                answer, sender = context.Pipe(duplex=False)
                process = context.Process(target=fly_program, args=(order, sender), daemon=True)
                process.start()
                sender.close()
                running[answer] = _Running(order, process, monotonic())
            yield from _ended(running, options.limits)
    finally:
        for one in running.values():
            _end(one.process)


def _ended(running: dict[Connection, _Running], limits: LicenceLimits) -> Iterator[FlownTrial]:
    """Yield the flights that have ended or are stuck."""
    ready = set(wait(list(running), timeout=1.0))
    for answer, one in list(running.items()):
        seconds = monotonic() - one.since
        if answer not in ready and seconds < STUCK_S:
            continue
        sent = received_log(answer) if answer in ready else None
        if answer in ready:
            one.process.join(DYING_S)
        died = one.process.exitcode
        _end(one.process)
        answer.close()
        del running[answer]
        trial = one.order.trial
        match sent:
            case LicenceLog():
                yield FlownTrial(trial, broken_rules(sent, limits), sent, seconds)
            case SimulatorFailure():
                yield FlownTrial(trial, (), None, seconds, sent)
            case None:
                yield FlownTrial(trial, (_without_log(died),), None, seconds)


def _end(process: BaseProcess) -> None:
    """End the process of a flight, and those that its program has started, which are in its group."""
    if process.pid is not None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.join()


def _without_log(status: int | None) -> BrokenRule:
    """Return what became of a process that sent no log; its exit status, None if it was still there."""
    if status is None:
        return BrokenRule(
            "program", 0.0, "the program does not end", f"its flight was ended after {STUCK_S:.0f} s"
        )
    why = f"exit status {status}" if status >= 0 else f"signal {-status}, {strsignal(-status)}"
    return BrokenRule("program", 0.0, "the program's process dies", why)
