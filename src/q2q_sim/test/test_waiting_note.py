"""When a flight that does not begin says what it waits for."""

from q2q_sim.node_flights.waiting_note import AGAIN_S, FIRST_S, WaitingNote


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
