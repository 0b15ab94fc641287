"""When a flight that does not begin says what it waits for."""

from queue import SimpleQueue
from threading import Timer
from threading import enumerate as enumerate_threads

from q2q_sim.node_flights.waiting_note import AGAIN_S, FIRST_S, LOADING, WaitingNote, noted_if_late


def test_a_long_wait_is_noted_after_a_while_and_then_periodically() -> None:
    note, waiting = WaitingNote(100.0), ["pid has not answered"]
    times = [100.0 + 0.5 * k for k in range(round(2 * (FIRST_S + AGAIN_S)))]
    noted = {now: said for now in times if (said := note.update(waiting, now))}
    assert list(noted) == [100.0 + FIRST_S]
    assert note.update(waiting, 100.0 + FIRST_S + AGAIN_S)
    assert noted[100.0 + FIRST_S] == "waiting for the nodes for 5 s: pid has not answered"


def test_a_note_names_three_and_counts_the_others() -> None:
    waiting = [f"mpc_cf{k} has not answered" for k in range(34)]
    said = WaitingNote(0.0).update(waiting, FIRST_S)
    assert said.endswith("mpc_cf2 has not answered; and 31 more")


def test_code_that_is_loaded_for_long_is_noted_before_any_node_answers() -> None:
    said = SimpleQueue[str]()
    with noted_if_late(said.put, 0.0):
        assert said.get(timeout=60.0) == LOADING


def test_nodes_that_start_in_time_are_not_noted() -> None:
    said = SimpleQueue[str]()
    with noted_if_late(said.put, 3600.0) as begun:
        (timer,) = (one for one in enumerate_threads() if isinstance(one, Timer))
        begun()
        timer.join(60.0)
        assert not timer.is_alive()
    assert said.empty()
