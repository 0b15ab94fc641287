"""One flight of a program, in the process that calls: it ends with the flight.

    patches of Python -> cflib, crazyflie_py -> program as __main__ -> rest of the flight -> log

The program's own exit closes its links like the end of a process: without a word. The vehicles then fly on
by their firmware, for BEGIN_S at least, until they rest or REST_S have passed. cflib may be missing;
crazyflie_py is a stand-in (crazyswarm) whose server is this process.
"""

import atexit
import logging
import os
import runpy
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from multiprocessing.connection import Connection
from types import FrameType
from typing import NoReturn

from q2q_model.signals.stamps import TICK_S
from q2q_model.vehicle.vehicle_uri import canonical_uri
from q2q_sim.licence.client_commands.client_command import FLIGHT
from q2q_sim.licence.crazyflie_py.modules import SwarmHost, install_modules
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle, stock_vehicles
from q2q_sim.licence.flight_order import FlightOrder
from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler
from q2q_sim.licence.program_process.last_lines import LastLines
from q2q_sim.licence.program_process.link_host import LinkHost
from q2q_sim.licence.program_process.patched_signals import replace_signals
from q2q_sim.licence.program_process.patched_threading import patch_threading, watch_threads
from q2q_sim.licence.program_process.program_lines import error_in, waiting_lines
from q2q_sim.licence.program_process.simulator_errors import SimulatorFailure, end_by, is_of_room
from q2q_sim.licence.room.licence_log import LicenceLog, ProgramEnd, escaped
from q2q_sim.licence.room.licence_room import LicenceRoom
from q2q_sim.processes.parent_death import die_with_parent

BEGIN_S = 0.5
"""Time in which a vehicle arms, in four updates of its supervisor, and follows its last command [s]."""
REST_S = 5.0
"""Longer than the firmware's watchdog of 2 s and a fall from the ceiling [s]."""
LOOK_S = 1.0
"""Wall time between two looks at such a flight [s]."""


class _Flight:
    """Flight of a program; the process ends with it."""

    def __init__(self, order: FlightOrder, answer: Connection) -> None:
        self._order, self._answer = order, answer
        self._uris = list(order.uris)
        self._output = LastLines()
        self._failed = ProgramEnd(0.0)
        self._caught = ""
        self._seen = (-1, 0.0)
        """Turns given and time [s] at the last look."""
        self._room = LicenceRoom(order.params, order.trial)
        self._scheduler = CooperativeScheduler(self._tick, TICK_S)
        host = LinkHost(self._room, self._scheduler, str(order.program.file), self._vehicle_of, order.scanned)
        self._links, self._swarms = host, SwarmHost(host, self._served)

    def run(self) -> NoReturn:
        """Fly the program and end this process."""
        program = self._order.program
        sys.stdout = sys.stderr = self._output
        sys.argv = [str(program.file), *program.arguments]
        sys.path.insert(0, str(program.file.parent))
        os.chdir(program.folder)
        patch_threading(self._scheduler)
        self._connect()
        signal.signal(signal.SIGALRM, self._end_if_outside)
        signal.setitimer(signal.ITIMER_REAL, self._order.timeout, LOOK_S)
        threading.excepthook = self._note_thread
        self._watch_callbacks()
        watch_threads(self._scheduler)
        replace_signals(self._scheduler)
        atexit._clear()  # noqa: SLF001  those of the process that this one was forked from
        end = self._end_of(lambda: runpy.run_path(str(program.file), run_name="__main__"))
        with suppress(KeyboardInterrupt):
            _join_threads()
        atexit._run_exitfuncs()  # noqa: SLF001  the program's, which may land vehicles
        self._swarms.settle()
        self._finish(end)

    def _connect(self) -> None:
        """Let cflib's links end in the room; cflib is imported after its calls have been replaced."""
        install_modules(self._swarms)
        if find_spec("cflib") is not None:
            from q2q_sim.licence.program_process.emulated_link import use_emulated_links

            use_emulated_links(self._links)

    def _served(self) -> tuple[ServedVehicle, ...]:
        """Return the vehicles of Crazyswarm2's server."""
        if self._order.served:
            return self._order.served
        rows = [self._vehicle_of(uri) for uri in self._order.scanned]
        return stock_vehicles(self._order.scanned, [self._order.params.starts[row] for row in rows])

    @property
    def _names(self) -> tuple[str, ...]:
        """Return the names of the vehicles, those of the server if the program knows it."""
        served = self._order.served or (self._served() if self._swarms.called else ())
        known = {canonical_uri(one.uri): one.name for one in served}
        opened = enumerate(map(canonical_uri, self._uris))
        return tuple(known.get(uri, f"cf{row + 1}") for row, uri in opened)

    def _vehicle_of(self, uri: str) -> int:
        known = [canonical_uri(one) for one in self._uris]
        vehicle = canonical_uri(uri)
        if vehicle in known:
            return known.index(vehicle)
        if self._order.served:
            raise ValueError(f"{uri} is not the URI of an enabled vehicle of the crazyflies.yaml")
        if len(known) == len(self._order.params.starts):
            self._send(ProgramEnd(self._room.t, unknown=uri))
        self._uris.append(uri)
        return len(known)

    def _tick(self) -> None:
        self._fly()
        asked = self._order.survey and any(one.asked.kind in FLIGHT for one in self._room.commands)
        if asked or self._room.t >= self._order.limit:
            self._send(self._overdue())

    def _fly(self) -> None:
        """Advance the room by one tick; the program, which may catch all errors, gets none of the room's."""
        try:
            self._room.fly()
        except Exception as error:
            if is_of_room(error):
                end_by(error, self._answer)
            raise

    def _end_if_outside(self, _: int, __: FrameType | None) -> None:
        """End the flight of a program that waits where no simulated time passes between two looks."""
        seen, self._seen = self._seen, (self._scheduler.given, self._scheduler.now)
        if seen == self._seen and not self._scheduler.handing_on:
            self._send(self._overdue(outside=True))

    def _overdue(self, *, outside: bool = False) -> ProgramEnd:
        waiting = waiting_lines(str(self._order.program.file))
        return ProgramEnd(self._room.t, overdue=True, waiting=waiting, outside=outside, caught=self._caught)

    def _end_of(self, run: Callable[[], object]) -> ProgramEnd:
        try:
            run()
        except SystemExit as left:
            code = left.code
            status = code if isinstance(code, int) else int(code is not None)
            return ProgramEnd(self._scheduler.now, status, str(code) if isinstance(code, str) else "")
        except BaseException as error:  # noqa: BLE001  a program may raise anything
            return self._error(error)
        return ProgramEnd(self._scheduler.now)

    def _error(self, error: BaseException) -> ProgramEnd:
        found = error_in(str(self._order.program.file), error)
        return ProgramEnd(self._scheduler.now, 1, *found)

    def _note_thread(self, args: "threading.ExceptHookArgs") -> None:
        """Note an error of a thread of the program; cflib's own threads are not the program's."""
        if args.exc_value is not None:
            end = self._error(args.exc_value)
            if end.line and not self._failed.status:
                self._failed = end

    def _watch_callbacks(self) -> None:
        """Note the first error of a callback: cflib logs it while it handles it."""
        made = logging.getLogRecordFactory()

        def noting(*args: object, **named: object) -> logging.LogRecord:
            record = made(*args, **named)
            error = sys.exception()
            if error is not None and record.name.startswith("cflib") and not self._caught:
                found = self._error(error)
                self._caught = f"{found.error}, line {found.line}" if found.line else ""
            return record

        logging.setLogRecordFactory(noting)

    def _finish(self, end: ProgramEnd) -> NoReturn:
        """Fly on without the program, which can no longer be interrupted, and send the log."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        _end_looks()
        if self._failed.status and not end.status:
            end = ProgramEnd(end.t, 1, self._failed.error, self._failed.line)
        ended = self._room.t
        while self._room.t < ended + (REST_S if self._room.is_active() else BEGIN_S):
            self._fly()
        self._send(end)

    def _send(self, end: ProgramEnd) -> NoReturn:
        _end_looks()
        if self._room.t == 0.0:
            self._fly()  # a log has a tick
        end = replace(end, error=escaped(end.error), caught=escaped(end.caught))
        output = escaped(self._output.text())
        self._answer.send(self._room.log(tuple(self._uris), self._names, end, output))
        self._answer.close()
        os._exit(0)


def _join_threads() -> None:
    """Wait for the threads of the program, as Python does at its end; Ctrl-C ends the wait."""
    for thread in threading.enumerate():
        if not thread.daemon and thread is not threading.current_thread():
            thread.join()


def _end_looks() -> None:
    """End the looks at the program, which fly ticks: what follows flies its own, and none within another."""
    for timer in (signal.ITIMER_PROF, signal.ITIMER_REAL):
        signal.setitimer(timer, 0.0)


def fly_program(order: FlightOrder, answer: Connection) -> NoReturn:
    """Fly a program in this process, send its LicenceLog, and end the process.

    In a session of its own: Ctrl-C in a terminal is for the process that asked for the flight, and ends this.
    """
    die_with_parent()
    os.setsid()
    try:
        _Flight(order, answer).run()
    except Exception as error:  # noqa: BLE001  those of the program end within
        end_by(error, answer)


def received_log(answer: Connection) -> LicenceLog | SimulatorFailure | None:
    """Return the log that a process has sent, or why the simulator failed in it; None if it ended without."""
    try:
        sent = answer.recv()
    except EOFError:
        return None
    return sent if isinstance(sent, LicenceLog | SimulatorFailure) else None
