"""Which nodes one process may run together."""

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from q2q_sim.ros.stack import StackParams


@pytest.mark.parametrize(
    ("nodes", "why"),
    [
        (("pid", "pid"), "give each node once"),
        (("bag_record", "mocap_filter", "bag_record"), "give each node once"),
        (("pid", "mpc"), "pid and mpc; choose one, as each writes command"),
        (("pidd",), "pidd; choose some of mocap_filter"),
        ((), "none; choose some of mocap_filter"),
    ],
)
def test_nodes_that_are_no_stack_are_refused(nodes: tuple[str, ...], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        StackParams(nodes)


def test_all_nodes_of_a_flight_with_one_controller_are_a_stack() -> None:
    chain = ("simulator", "mocap_filter", "interference", "trajectory", "replanner", "mpc", "bag_record")
    assert StackParams(chain).nodes == chain
