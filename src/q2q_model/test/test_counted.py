"""A count has its noun in the plural unless it is one."""

import pytest

from q2q_model.counted import counted
from q2q_model.diagnostics.health import Health, health_report


@pytest.mark.parametrize(("count", "words"), [(0, "0 ticks"), (1, "1 tick"), (21, "21 ticks")])
def test_one_alone_is_singular(count: int, words: str) -> None:
    assert counted(count, "tick") == words


def test_a_node_that_has_done_one_tick_says_so() -> None:
    assert health_report(Health(), Health(ticks=1)).summary == "1 tick"
