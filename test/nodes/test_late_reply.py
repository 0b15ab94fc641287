"""A service that answers late answers every caller."""

from collections.abc import Iterator

import pytest

pytest.importorskip("rclpy", reason="ROS is not sourced")

import rclpy
from rclpy.node import Node
from spun_until import spin_until
from std_srvs.srv import Trigger

from q2q_model.node.reply import Reply
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.late_reply import LateReplyService
from q2q_sim.processes.domain import own_domain


@pytest.fixture
def node() -> Iterator[Node]:
    """Return a node in a domain of its own."""
    with own_domain():
        rclpy.init()
        made = Node("late")
        yield made
        made.destroy_node()
        rclpy.try_shutdown()


def test_one_answer_is_sent_to_all_who_wait_and_to_none_twice(node: Node) -> None:
    asked: list[int] = []

    def ask() -> None:
        asked.append(node.get_clock().now().nanoseconds)

    service = LateReplyService(node, "~/stop", ask)
    client, executor = node.create_client(Trigger, "~/stop"), make_executor()
    executor.add_node(node)
    spin_until(executor, client.service_is_ready, "the service")
    for called, said in ((2, "both are locked"), (4, "they are locked still")):
        calls = [client.call_async(Trigger.Request()) for _ in range(2)]
        spin_until(executor, lambda called=called: len(asked) == called, "both calls")
        assert not any(one.done() for one in calls)
        service.answer(Reply(granted=True, reason=said))
        spin_until(executor, lambda calls=calls: all(one.done() for one in calls), "both answers")
        assert [one.result().message for one in calls] == [said, said]
