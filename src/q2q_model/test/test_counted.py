"""A count has its noun in the plural unless it is one; parts beyond the first are counted."""

import pytest

from q2q_model.counted import counted, difference, first_of
from q2q_model.diagnostics.health import Health, health_report


@pytest.mark.parametrize(("count", "words"), [(0, "0 ticks"), (1, "1 tick"), (21, "21 ticks")])
def test_one_alone_is_singular(count: int, words: str) -> None:
    assert counted(count, "tick") == words


def test_a_node_that_has_done_one_tick_says_so() -> None:
    assert health_report(Health(), Health(ticks=1)).summary == "1 tick"


@pytest.mark.parametrize(
    ("most", "parts"), [(3, ["a", "b", "c"]), (2, ["a", "b", "and 1 more"]), (0, ["and 3 more"])]
)
def test_parts_beyond_the_first_are_counted(most: int, parts: list[str]) -> None:
    assert first_of(("a", "b", "c"), most) == parts


def test_names_differ_by_those_that_are_lacking_and_those_that_are_there_besides() -> None:
    flown = [f"cf{k}" for k in range(1, 31)]
    assert difference([*flown[:29], "cf31"], flown) == "lacks cf30 and has cf31"
    assert difference(flown[1:], flown) == "lacks cf1"
    assert difference([*flown, "cf31"], flown) == "has cf31"
    assert not difference(flown[::-1], flown)
