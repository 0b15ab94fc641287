"""Handlers of signals by the scheduler of a program, with SIGINT as Python has it at the start of a program.

Replaced are `signal.signal`, `signal.getsignal` and `os.kill`. The processes of a licence are forked from one
that ignores SIGINT. A program may send that signal to itself (`_thread.interrupt_main`, `os.kill`); os.kill
returns when the main thread has noticed it, as otherwise simulated time might pass meanwhile.
"""

import _thread
import os
import signal
from collections.abc import Callable
from types import FrameType

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler

NOTICED_S = 10.0
"""Longest wait for the main thread of a busy machine [s]."""
Handling = Callable[[int, FrameType | None], object]
Handler = Handling | int | None


def replace_signals(scheduler: CooperativeScheduler) -> None:
    """Replace the calls for the rest of this process; the calling thread is the program's main thread."""
    install, installed, send = signal.signal, signal.getsignal, os.kill
    main, noticed = _thread.get_ident(), _thread.allocate_lock()
    noticed.acquire()
    of_program: dict[int, Handling] = {}

    def handle(number: int, frame: FrameType | None) -> None:
        if noticed.locked():
            noticed.release()
        scheduler.handle(lambda: of_program[number](number, frame))

    def handler_of(number: int) -> Handler:
        found = installed(number)
        return of_program[number] if found is handle else found

    def set_handler(number: int, handler: Handler) -> Handler:
        before = handler_of(number)
        install(number, handle if callable(handler) else handler)
        if callable(handler):
            of_program[number] = handler
        return before

    def kill(pid: int, number: int) -> None:
        awaited = pid == os.getpid() and installed(number) is handle and _thread.get_ident() != main
        if awaited:
            noticed.acquire(blocking=False)
        send(pid, number)
        if awaited:
            noticed.acquire(timeout=NOTICED_S)

    setattr(os, "kill", kill)  # noqa: B010
    setattr(signal, "getsignal", handler_of)  # noqa: B010
    setattr(signal, "signal", set_handler)  # noqa: B010
    signal.signal(signal.SIGINT, signal.default_int_handler)
