"""One thread of a program runs at a time, and the clock of all is that of the room."""

import threading
from collections.abc import Callable

import pytest

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler, always


def start(scheduler: CooperativeScheduler, run: Callable[[], None]) -> threading.Thread:
    gate = scheduler.enter()

    def body() -> None:
        scheduler.take(gate)
        run()
        scheduler.leave()

    thread = threading.Thread(target=body, daemon=True)
    thread.start()
    return thread


def test_threads_wake_in_the_order_of_their_deadlines_and_ticks_pass_between() -> None:
    seen: list[tuple[str, float]] = []
    scheduler = CooperativeScheduler(lambda: seen.append(("tick", scheduler.now)), 1.0)

    def sleeper(name: str, seconds: float) -> Callable[[], None]:
        def run() -> None:
            scheduler.sleep(seconds)
            seen.append((name, scheduler.now))

        return run

    threads = [start(scheduler, sleeper("late", 1.5)), start(scheduler, sleeper("early", 0.5))]
    scheduler.sleep(2.5)
    for thread in threads:
        thread.join()
    assert seen == [("early", 0.5), ("tick", 1.0), ("late", 1.5), ("tick", 2.0)]


def test_a_condition_ends_a_wait_before_its_deadline_and_computing_takes_no_time() -> None:
    scheduler = CooperativeScheduler(lambda: None, 1.0)
    done: list[float] = []
    thread = start(scheduler, lambda: done.append(scheduler.now))
    assert scheduler.wait(lambda: bool(done), 5.0)
    thread.join()
    assert (scheduler.now, done) == (0.0, [0.0])
    assert not scheduler.wait(lambda: False, 0.25)
    assert scheduler.now == 0.25


def test_reading_a_clock_lets_time_pass_and_others_go_on() -> None:
    ticks: list[float] = []
    scheduler = CooperativeScheduler(lambda: ticks.append(scheduler.now), 0.01)
    while scheduler.now < 0.05:
        scheduler.spend(0.003)
    assert ticks == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    assert scheduler.wait(always, 1.0)
