"""Licence of a program: its flight without faults, then, if that passes, with one fault each.

Every flight has a process of its own, forked from the fork server, which has imported the simulator. One tick
is warmed up before all flights: compiling the kernels is no time of a program, and an air that cannot be
flown in is refused.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from signal import strsignal
from time import monotonic

from q2q_model.counted import counted
from q2q_model.signals.values import Three
from q2q_sim.experiments.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.experiments.licence.flight_order import PROGRAM_TIMEOUT_S, FlightOrder, Program
from q2q_sim.experiments.licence.guided_trials import trials_after
from q2q_sim.experiments.licence.program.simulator_errors import SimulatorFailure
from q2q_sim.experiments.licence.program_flight import fly_program, received_log
from q2q_sim.experiments.licence.room.licence_log import LicenceLog
from q2q_sim.experiments.licence.room.licence_room import LicenceParams, LicenceRoom
from q2q_sim.experiments.licence.room.trials import LicenceTrial
from q2q_sim.experiments.licence.rules.broken_rule import BrokenRule
from q2q_sim.experiments.licence.rules.licence_limits import LicenceLimits
from q2q_sim.experiments.licence.rules.licence_rules import broken_rules
from q2q_sim.processes.fork_server import start_fork_server
from q2q_sim.sensors.range_finder import RoomBox

MOST_VEHICLES = 15
"""Vehicles of one radio."""
SPACING = 1.0
"""Distance of neighbours on the floor [m]."""
ASIDE = 1.5
"""Distance of the outermost from the walls [m]: a leg of 1 m does not end at one."""
DYING_S = 5.0
"""Longest time from the end of a process's output to its own [s]."""
LONGER_S = 30.0
"""Time that a program may take longer with a fault than without [s]."""
STUCK_S = PROGRAM_TIMEOUT_S + 10.0
"""Wall time after which the process of a flight is ended from outside [s]."""


@dataclass(frozen=True, slots=True)
class LicenceOptions:
    """Conditions of a licence."""

    starts: tuple[Three, ...] = ()
    """x, y [m], yaw [rad] of the vehicles in the order of their URIs; empty for rows along y, SPACING apart
    (`rows_of`)."""
    limits: LicenceLimits = field(default_factory=LicenceLimits)
    air: str = "room"
    seed: int = 0
    arming: bool = False
    scanned: tuple[str, ...] = ()
    """URIs that a scan answers."""
    served: tuple[ServedVehicle, ...] = ()
    """Vehicles of a crazyflies.yaml; empty if there is none."""
    limit: float = 300.0
    """Longest flight without faults [s]."""
    jobs: int = 2
    budget: float = 540.0
    """Wall time after which no flight but the first starts [s]."""

    def params(self, count: int) -> LicenceParams:
        """Return the room with `count` vehicles."""
        served = tuple(one.start for one in self.served)
        starts = self.starts[:count] if len(self.starts) >= count else served or self.rows_of(count)
        room = RoomBox(*self.limits.half_room, self.limits.ceiling)
        return LicenceParams(starts, self.air, self.seed, self.arming, room)

    def rows_of(self, count: int) -> tuple[Three, ...]:
        """Return starts of `count` vehicles in rows along y, as few as the room has space for."""
        fit = max(1 + int(2.0 * (self.limits.half_room[1] - ASIDE) / SPACING), 1)
        rows = -(-count // fit)
        wide = -(-count // rows)
        middle_x, middle_y = 0.5 * (rows - 1), 0.5 * (wide - 1)
        return tuple(
            (SPACING * (k // wide - middle_x), SPACING * (k % wide - middle_y), 0.0) for k in range(count)
        )


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


@dataclass(frozen=True, slots=True)
class Licence:
    """Outcome of all flights of a program."""

    program: Program
    flights: tuple[FlownTrial, ...]
    left_out: tuple[LicenceTrial, ...]
    """Trials for which there was no time."""
    seconds: float

    @property
    def passed(self) -> bool:
        """Return whether every flight passed, and all were flown."""
        return all(one.passed for one in self.flights) and not self.left_out

    @property
    def flew(self) -> bool:
        """Return whether a vehicle was in the air in the flight without faults."""
        log = self.flights[0].log
        return log is not None and bool(log.flew.any())

    @property
    def failed(self) -> tuple[FlownTrial, ...]:
        """Return the flights with broken rules."""
        return tuple(one for one in self.flights if one.failures)

    @property
    def errors(self) -> tuple[FlownTrial, ...]:
        """Return the flights in which the simulator failed."""
        return tuple(one for one in self.flights if one.error is not None)

    @property
    def judged(self) -> bool:
        """Return whether the program failed, or the simulator did in no flight."""
        return bool(self.failed) or not self.errors


def licence(program: Program, options: LicenceOptions) -> Licence:
    """Return the licence of a program.

    Raises:
        AirError: the air does not exist, or cannot be flown in.
        ValueError: there are starts, but not one for each vehicle.
    """
    start_fork_server()
    LicenceRoom(options.params(1), LicenceTrial()).fly()  # warm-up, while the fork server imports
    began = monotonic()
    until = began + options.budget
    nominal = _nominal(program, options, until)
    flights, left_out = [nominal], []
    if nominal.passed and nominal.log is not None:
        log = nominal.log
        if len(options.starts) > len(log.uris):
            raise _unmatched(options, len(log.uris))
        limit = log.end.t + LONGER_S
        trials = trials_after(log)
        orders = [replace(_first_order(program, options, log.uris), trial=one, limit=limit) for one in trials]
        flights += fly_trials(orders, options, until)
        done = {one.trial for one in flights}
        left_out = [one for one in trials if one not in done]
    return Licence(program, tuple(flights), tuple(left_out), monotonic() - began)


def _nominal(program: Program, options: LicenceOptions, until: float) -> FlownTrial:
    """Return the flight without faults, with as many vehicles as the program opens."""
    order = _first_order(program, options, tuple(one.uri for one in options.served))
    flown = _fly(order, options, inf)
    if not _unknown(flown):
        return flown
    survey = replace(order, params=options.params(MOST_VEHICLES), survey=True)
    flown = _fly(survey, options, until)
    uris = flown.log.uris if flown.log is not None else ()
    while flown.log is not None:  # each flight ends where it opens a vehicle that the ones before did not
        flown = _fly(_first_order(program, options, tuple(sorted(uris))), options, until)
        if not _unknown(flown) or len(uris) == MOST_VEHICLES:
            break
        uris = (*uris, _unknown(flown))
    return flown


def _fly(order: FlightOrder, options: LicenceOptions, until: float) -> FlownTrial:
    """Return a flight without faults; after `until` (monotonic [s]) one that fails for want of time."""
    for flown in fly_trials([order], options, until):
        return flown
    what = "there is no time left to fly all vehicles that the program opens"
    return FlownTrial(order.trial, (BrokenRule("program", 0.0, what),), None, 0.0)


def _unknown(flown: FlownTrial) -> str:
    """Return the URI that the program opened after those of all vehicles; empty if it opened none."""
    return "" if flown.log is None else flown.log.end.unknown


def _first_order(program: Program, options: LicenceOptions, uris: tuple[str, ...]) -> FlightOrder:
    """Return the order of a flight without faults; without URIs, of one vehicle.

    Raises:
        ValueError: there are starts, but fewer than vehicles.
    """
    if 0 < len(options.starts) < len(uris):
        raise _unmatched(options, len(uris))
    params = options.params(max(len(uris), 1))
    return FlightOrder(program, params, LicenceTrial(), uris, options.scanned, options.limit, options.served)


def _unmatched(options: LicenceOptions, count: int) -> ValueError:
    """Return the error for starts that are not as many as the vehicles."""
    given, vehicles = len(options.starts), counted(count, "vehicle")
    return ValueError(f"{given} --start for {vehicles}: give one for each, or none")


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
            one.process.kill()
            one.process.join()


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
        one.process.kill()
        one.process.join()
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


def _without_log(status: int | None) -> BrokenRule:
    """Return what became of a process that sent no log; its exit status, None if it was still there."""
    if status is None:
        return BrokenRule(
            "program", 0.0, "the program does not end", f"its flight was ended after {STUCK_S:.0f} s"
        )
    why = f"exit status {status}" if status >= 0 else f"signal {-status}, {strsignal(-status)}"
    return BrokenRule("program", 0.0, "the program's process dies", why)
