"""The warm-up of an `mpc` node runs what a later tick may need: bounds, vehicles of other controllers."""

from collections.abc import Callable

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticArray
from room_node import RoomNode

from q2q_control.mpc.neighbours import constant_velocity
from q2q_control.mpc.prediction import downwash_horizon
from q2q_control.mpc.solver import horizon_solver
from q2q_control.ros import mpc_node
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmSetpoint, SwarmState

ALONE = {"vehicles": ("cf1",)}


@pytest.mark.parametrize("given", [{}, {"aware": False}, ALONE, ALONE | {"distributed": True}])
@pytest.mark.parametrize("model", ["none", "paper_law"])
def test_every_kernel_of_a_tick_runs_before_the_first(
    model: str, given: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: set[str] = set()

    def noted(kernel: Callable[..., object]) -> Callable[..., object]:
        def run(*values: object) -> object:
            ran.add(kernel.__name__)
            return kernel(*values)

        return run

    kernels = [(horizon_solver, "solve_group"), (constant_velocity, "_straight_on")]
    if model != "none" and given.get("aware", True):
        kernels.append((downwash_horizon, "may_reach"))
    for module, name in kernels:
        monkeypatch.setattr(module, name, noted(getattr(module, name)))
    mpc_node.build(RoomNode("mpc", {"model": model, **given}, {}))
    assert ran == {name for _, name in kernels}


def test_diagnostics_show_the_recursions_of_ticks_and_none_of_the_warm_up() -> None:
    node = RoomNode("mpc", {"aware": False}, {})
    mpc_node.build(node)
    assert _reported_iterations(node) == 0
    for topic, signal in (("state", SwarmState), ("reference_safe", SwarmSetpoint)):
        node.takers[topic](encode(synthetic_signal(signal, 1.0), 10**9))
    assert _reported_iterations(node) > 0


def _reported_iterations(node: RoomNode) -> int:
    for _, act in node.timers:
        act()
    last = node.published["/diagnostics"][-1]
    assert isinstance(last, DiagnosticArray)
    return int({value.key: value.value for value in last.status[0].values}["iterations"])
