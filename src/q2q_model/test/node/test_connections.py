"""When the nodes of a flight are connected."""

import pytest

from q2q_model.node.connections import (
    Connections,
    conflicting_topics,
    connections_from_text,
    undelivered_topics,
    unmatched_topics,
)

SOURCE = Connections(reads=("/command",), matched={"/mocap": 2})
FILTER = Connections(reads=("/mocap",), matched={"/state": 1})
PID = Connections(reads=("/state", "/mocap"), matched={"/command": 1})


def test_nodes_are_connected_once_every_writer_has_matched_all_that_read_its_topic() -> None:
    assert unmatched_topics({"source": SOURCE, "filter": FILTER, "pid": PID}) == {}


def test_a_reader_that_no_writer_has_matched_yet_is_missed_by_the_writers_name() -> None:
    late = Connections(reads=("/mocap",), matched={})
    nodes = {"source": SOURCE, "filter": FILTER, "pid": PID, "late": late}
    assert unmatched_topics(nodes) == {"source": ["/mocap"]}


def test_a_strangers_reader_more_than_ours_does_no_harm() -> None:
    assert unmatched_topics({"source": Connections(("/state",), {"/mocap": 5}), "filter": FILTER}) == {}


def test_a_latched_value_is_waited_for_where_it_is_out() -> None:
    reader = Connections(reads=("/plan",), matched={}, lacks=("/plan",))
    player = Connections((), {"/plan": 1}, out=("/plan",))
    assert undelivered_topics({"mpc": reader, "player": player}) == {"mpc": ["/plan"]}
    silent = Connections((), {"/plan": 1})  # it comes with the first tick
    assert undelivered_topics({"mpc": reader, "player": silent}) == {}
    served = Connections(reads=("/plan",), matched={})
    assert undelivered_topics({"mpc": served, "player": player}) == {}


def test_connections_survive_their_text() -> None:
    several = Connections(("/a", "/b", "/b"), {"/c": 2, "/d": 0})
    latched = Connections(("/plan",), {"/plan": 1}, out=("/plan",), lacks=("/model",))
    for one in (SOURCE, FILTER, PID, several, latched, Connections((), {})):
        assert connections_from_text(one.as_text(), "pid") == one


@pytest.mark.parametrize(
    "text",
    ["yes", "/state=many", "/state=", "/state", "=1", "</a yes", "{}", "/a=1.5", "/a=-1", "x" * 10_000],
)
def test_an_answer_that_reports_no_connections_is_refused_with_the_node_that_gave_it(text: str) -> None:
    with pytest.raises(ValueError, match=r"^pid answers '[^\n]{0,40}' to ~/ready, not topics .* end it, or"):
        connections_from_text(text, "pid")


def test_signals_that_other_nodes_write_are_named_with_all_who_write_them() -> None:
    nodes = {
        "simulator": Connections((), {"/mocap": 1, "/clock": 1}),
        "mocap_filter": Connections((), {"/state": 2}),
    }
    writers = {"/mocap": ["simulator"], "/clock": ["simulator", "other"], "/state": ["mocap_filter"]}
    assert conflicting_topics(nodes, writers.__getitem__) == ""
    writers["/mocap"] = ["simulator", "forgotten"]
    message = conflicting_topics(nodes, writers.__getitem__)
    assert message == "/mocap is written by 2 nodes (forgotten, simulator)"
    writers["/mocap"] = ["simulator", "simulator"]
    assert conflicting_topics(nodes, writers.__getitem__).endswith("by 2 nodes (simulator, simulator)")
