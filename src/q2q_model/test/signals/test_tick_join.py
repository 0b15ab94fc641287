"""Joining a tick's inputs by stamp."""

from hypothesis import given
from hypothesis import strategies as st

from q2q_model.signals.tick_join import WAITING_TICKS, TickJoin


def test_a_tick_is_complete_once_every_topic_has_its_stamp_in_the_order_of_the_topics() -> None:
    join: TickJoin[str] = TickJoin(("state", "reference"))
    assert join.put("reference", 10, "r10") is None
    assert join.put("reference", 20, "r20") is None
    assert join.put("state", 20, "s20") == ("s20", "r20")


def test_completing_a_tick_gives_up_the_older_ones_and_counts_them() -> None:
    join: TickJoin[str] = TickJoin(("state", "reference"))
    join.put("state", 10, "s10")
    join.put("state", 20, "s20")
    assert join.put("reference", 20, "r20") is not None
    assert join.missed == 1
    assert join.put("reference", 10, "r10") is None


def test_a_repeated_tick_is_answered_again() -> None:
    join: TickJoin[int] = TickJoin(("a", "b"))
    for _ in range(2):
        join.put("a", 10, 1)
        assert join.put("b", 10, 2) == (1, 2)
    assert join.missed == 0


def test_an_input_of_a_complete_tick_that_comes_again_is_no_missed_tick() -> None:
    join: TickJoin[int] = TickJoin(("a", "b"))
    for stamp in (1, 2, 3):
        join.put("a", stamp, 0)
        assert join.put("b", stamp, 0) is not None
        join.put("a", stamp, 0)
    assert join.missed == 0


def test_a_missed_tick_is_counted_once_though_its_other_input_comes_late() -> None:
    join: TickJoin[int] = TickJoin(("a", "b"))
    join.put("a", 1, 0)
    for stamp in (2, 3):
        join.put("a", stamp, 0)
        assert join.put("b", stamp, 0) is not None
        join.put("b", 1, 0)
    assert join.missed == 1


def test_memory_is_bounded_when_one_topic_never_comes() -> None:
    join: TickJoin[int] = TickJoin(("a", "b"))
    for stamp in range(100):
        join.put("a", stamp, stamp)
    assert join.missed == 100 - WAITING_TICKS


def test_a_join_as_deep_as_its_queues_loses_no_tick_of_a_backlog() -> None:
    join: TickJoin[int] = TickJoin(("a", "b"), waiting=1000)
    for stamp in range(1000):
        join.put("a", stamp, stamp)
    assert [join.put("b", stamp, -stamp) for stamp in range(1000)] == [(t, -t) for t in range(1000)]
    assert join.missed == 0


@given(st.permutations([(topic, stamp) for topic in "abc" for stamp in (1, 2, 3)]))
def test_whatever_the_order_a_tick_has_its_own_values(order: list[tuple[str, int]]) -> None:
    join: TickJoin[tuple[str, int]] = TickJoin(("a", "b", "c"))
    done = [made for topic, stamp in order if (made := join.put(topic, stamp, (topic, stamp)))]
    assert all(made == (("a", made[0][1]), ("b", made[0][1]), ("c", made[0][1])) for made in done)
    assert done[-1][0][1] == 3 or any(made[0][1] == 3 for made in done)


def test_it_reports_what_incomplete_ticks_lack() -> None:
    join: TickJoin[int] = TickJoin(("state", "reference", "interference"))
    assert join.lacking() == "state, reference, interference not received"
    for stamp in range(20):
        join.put("state", stamp, 0)
        join.put("reference", stamp, 0)
    assert join.lacking() == "interference not received, reference, state received"
    join.put("interference", 99, 0)
    assert join.lacking() == "state, reference, interference received, never with the same stamp"
