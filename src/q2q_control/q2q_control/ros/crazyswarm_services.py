"""Call Crazyswarm2's services for all vehicles: take-off, landing, arming, and that setpoints stop."""

from collections.abc import Callable
from functools import partial

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_control.ros.crazyswarm_types import CRAZYFLIE_PACKAGE, find

NAMES = ("Takeoff", "Land", "Arm", "NotifySetpointsStop")
TOPICS = ("all/takeoff", "all/land", "all/arm", "all/notify_setpoints_stop")


class CrazyswarmServices:
    """Hold the clients, and offer `~/take_off`, `~/land`, `~/arm`, `~/disarm`, `~/notify_setpoints_stop`."""

    def __init__(self, node: Node, height: float, seconds: float) -> None:
        """Take the height [m] and the duration [s] of take-off and landing.

        Raises:
            ImportError: crazyflie_interfaces is missing.
        """
        self._node = node
        types = find(CRAZYFLIE_PACKAGE, NAMES, "srv")
        self._clients = [node.create_client(one, topic) for one, topic in zip(types, TOPICS, strict=True)]
        take_off, land, arm, stop = (one.Request for one in types)  # type: ignore[attr-defined]
        whole, rest = divmod(round(seconds * 1e9), 1_000_000_000)
        lasting = Duration(sec=whole, nanosec=rest)
        self._offer("take_off", 0, partial(take_off, height=height, duration=lasting))
        self._offer("land", 1, partial(land, height=0.0, duration=lasting))
        self._offer("arm", 2, partial(arm, arm=True))
        self._offer("disarm", 2, partial(arm, arm=False))
        self._offer("notify_setpoints_stop", 3, stop)

    def _offer(self, name: str, which: int, request: Callable[[], object]) -> None:
        client, topic = self._clients[which], TOPICS[which]

        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            if not client.service_is_ready():
                response.success, response.message = (
                    False,
                    f"{topic} does not answer: start Crazyswarm2's server",
                )
                return response
            client.call_async(request()).add_done_callback(partial(self._done, topic))
            response.success, response.message = True, f"asked {topic}"
            return response

        self._node.create_service(Trigger, f"~/{name}", answer)

    def _done(self, topic: str, future: Future) -> None:
        wrong = future.exception()
        if wrong is not None:
            self._node.get_logger().error(f"{topic}: {wrong}")
