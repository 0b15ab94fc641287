"""Client of the node `trajectory`: wait, transit, start, hold.

It waits by `wait_landed`: the procedure lets only vehicles take off that stand on the ground.
"""

from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_control.flight_procedure.steps import Act
from q2q_model.node.reply import Reply

CALLS = {Act.WAIT: "wait_landed", Act.TRANSIT: "transit", Act.START: "start", Act.BRAKE: "hold"}
"""The service of each act."""


class TrajectoryClient:
    """Clients of the node `trajectory`, and the answer to the last call."""

    def __init__(self, node: Node) -> None:
        self._clients = {
            act: node.create_client(Trigger, f"trajectory/{name}") for act, name in CALLS.items()
        }
        self._reply: Reply | None = None
        self._future: Future[Trigger.Response] | None = None

    def begin(self, act: Act) -> None:
        """Call the service of an act."""
        client = self._clients[act]
        self._reply, self._future = None, None
        if not client.service_is_ready():
            words = f"{client.srv_name} does not answer: start trajectory with wait:=true"
            self._reply = Reply(granted=False, reason=words)
            return
        self._future = client.call_async(Trigger.Request())

    def outcome(self) -> Reply | None:
        """Return the answer to the last call, once; None while there is none."""
        future = self._future
        if future is not None and future.done():
            response = future.result()
            self._reply = Reply(granted=response.success, reason=response.message)
            self._future = None
        reply, self._reply = self._reply, None
        return reply
