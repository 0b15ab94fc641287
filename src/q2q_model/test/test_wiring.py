"""When the nodes of a flight are wired."""

from q2q_model.node.wiring import Wiring, other_writers, undelivered, unmatched, wiring_from_text

SOURCE = Wiring(reads=("/command",), matched={"/mocap": 2})
FILTER = Wiring(reads=("/mocap",), matched={"/state": 1})
PID = Wiring(reads=("/state", "/mocap"), matched={"/command": 1})


def test_nodes_are_wired_once_every_writer_has_matched_all_that_read_its_topic() -> None:
    assert unmatched({"source": SOURCE, "filter": FILTER, "pid": PID}) == {}


def test_a_reader_that_no_writer_has_matched_yet_is_missed_by_the_writers_name() -> None:
    late = Wiring(reads=("/mocap",), matched={})
    nodes = {"source": SOURCE, "filter": FILTER, "pid": PID, "late": late}
    assert unmatched(nodes) == {"source": ["/mocap"]}


def test_a_strangers_reader_more_than_ours_does_no_harm() -> None:
    assert unmatched({"source": Wiring(("/state",), {"/mocap": 5}), "filter": FILTER}) == {}


def test_a_latched_value_is_waited_for_where_it_is_out() -> None:
    reader = Wiring(reads=("/plan",), matched={}, lacks=("/plan",))
    assert undelivered({"mpc": reader, "player": Wiring((), {"/plan": 1}, out=("/plan",))}) == {
        "mpc": ["/plan"]
    }
    assert (
        undelivered({"mpc": reader, "player": Wiring((), {"/plan": 1})}) == {}
    )  # it comes with the first tick
    served = Wiring(reads=("/plan",), matched={})
    assert undelivered({"mpc": served, "player": Wiring((), {"/plan": 1}, out=("/plan",))}) == {}


def test_wiring_survives_its_text() -> None:
    several = Wiring(("/a", "/b", "/b"), {"/c": 2, "/d": 0})
    latched = Wiring(("/plan",), {"/plan": 1}, out=("/plan",), lacks=("/model",))
    for wiring in (SOURCE, FILTER, PID, several, latched, Wiring((), {})):
        assert wiring_from_text(wiring.as_text()) == wiring


def test_signals_that_other_nodes_write_are_named_with_all_who_write_them() -> None:
    nodes = {"simulator": Wiring((), {"/mocap": 1, "/clock": 1}), "mocap_filter": Wiring((), {"/state": 2})}
    writers = {"/mocap": ["simulator"], "/clock": ["simulator", "other"], "/state": ["mocap_filter"]}
    assert other_writers(nodes, writers.__getitem__) == ""
    writers["/mocap"] = ["simulator", "forgotten"]
    told = other_writers(nodes, writers.__getitem__)
    assert told == "/mocap is written by 2 nodes (forgotten, simulator)"
    writers["/mocap"] = ["simulator", "simulator"]
    assert other_writers(nodes, writers.__getitem__).endswith("by 2 nodes (simulator, simulator)")
