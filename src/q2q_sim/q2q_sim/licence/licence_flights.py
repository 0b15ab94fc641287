"""Licence of a program: its flight without faults, then, if that passes, with one fault each.

One tick is warmed up before all flights: compiling the kernels is no time of a program, and an air that
cannot be flown in is refused.
"""

from dataclasses import dataclass, replace
from math import inf
from time import monotonic

from q2q_model.counted import counted
from q2q_sim.licence.fault_trials import trials_after
from q2q_sim.licence.flight_order import FlightOrder, Program
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.room.licence_room import LicenceRoom
from q2q_sim.licence.room.trials import LicenceTrial
from q2q_sim.licence.rules.broken_rule import BrokenRule
from q2q_sim.licence.trial_processes import FlownTrial, fly_trials
from q2q_sim.processes.fork_server import start_fork_server

MOST_VEHICLES = 15
"""Vehicles of one radio."""
LONGER_S = 30.0
"""Time that a program may take longer with a fault than without [s]."""


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
    what = "no time is left to fly all vehicles that the program opens"
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
