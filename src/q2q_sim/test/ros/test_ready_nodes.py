"""A node that waits for others asks again: the node that was asked may have been restarted."""

from dataclasses import dataclass, field

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_sim.ros import ready_nodes
from q2q_sim.ros.ready_nodes import AGAIN_S, ReadyNodes
from q2q_sim.ros.stand_in import StandInNode


@dataclass
class _Asked:
    """Client whose questions are answered by the test."""

    calls: list[Future] = field(default_factory=list)
    given_up: list[Future] = field(default_factory=list)

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, _: Trigger.Request) -> Future:
        self.calls.append(Future())
        return self.calls[-1]

    def remove_pending_request(self, call: Future) -> None:
        self.given_up.append(call)


class _Node(StandInNode):
    subscriptions = publishers = ()

    def create_client(self, kind: type, name: str) -> _Asked:
        super().create_client(kind, name)
        self.asked = _Asked()
        return self.asked


def test_a_question_that_is_lost_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(ready_nodes, "monotonic", lambda: now[0])
    node = _Node("simulator", {})
    others = ReadyNodes(node, ("pid",))
    for now[0] in (0.0, AGAIN_S):
        assert others.missing() == ["pid has not answered"]
    lost = node.asked.calls[0]
    assert node.asked.calls == [lost]
    now[0] = AGAIN_S + 0.1
    assert others.missing() == ["pid has not answered"]
    assert node.asked.given_up == [lost]
    node.asked.calls[1].set_result(Trigger.Response(success=True, message=""))
    assert others.missing() == []


def test_an_answer_of_another_program_is_refused_with_its_node() -> None:
    node = _Node("simulator", {})
    others = ReadyNodes(node, ("pid",))
    assert others.missing() == ["pid has not answered"]
    node.asked.calls[0].set_result(Trigger.Response(success=True, message="sure"))
    with pytest.raises(ValueError, match=r"^pid answers 'sure' to ~/ready"):
        others.missing()
