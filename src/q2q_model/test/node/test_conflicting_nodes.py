"""Whether another node publishes the topics of a radio node's vehicles."""

import pytest

from q2q_model.node.connections import conflicting_nodes


@pytest.mark.parametrize(
    ("publishers", "others"),
    [
        ([], ""),
        ([["radio"], ["radio"]], ""),
        ([["radio"], ["radio", "b", "a"]], "a, b"),
        ([["radio", "radio"], ["radio"]], "radio"),
    ],
)
def test_other_nodes_and_namesakes_are_named_and_the_node_itself_is_not(
    publishers: list[list[str]], others: str
) -> None:
    assert conflicting_nodes("radio", publishers) == others
