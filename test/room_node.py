"""A node of ours whose topics, services and timers are those of a room in simulated time."""

from collections.abc import Callable
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from q2q_control.ros.crazyswarm_bridge import POSES_OUT
from q2q_model.diagnostics.health import Level
from q2q_model.node.reply import Reply
from q2q_model.ros.node.diagnostics_publisher import PERIOD_S
from q2q_sim.ros.stand_in import StandInNode

Servers = dict[str, Callable[[object], object]]
"""What stands behind each service that the node calls."""


@dataclass
class Future:
    """An answer that is there."""

    answer: object

    def done(self) -> bool:
        """Return True: it is there."""
        return True

    def result(self) -> object:
        """Return the answer."""
        return self.answer

    def exception(self) -> None:
        """Return None: nothing went wrong."""
        return


@dataclass(frozen=True)
class Writer:
    """Publisher, as ROS describes it."""

    node_name: str
    node_namespace: str = "/"


@dataclass(frozen=True)
class Reader:
    """Subscription, as ROS describes it."""

    node_name: str
    qos_profile: QoSProfile


@dataclass
class Client:
    """Client of a service; what stands behind it answers at once, or nobody does."""

    srv_name: str
    serve: Callable[[object], object] | None

    def service_is_ready(self) -> bool:
        """Return whether somebody serves it."""
        return self.serve is not None

    def call_async(self, request: object) -> Future:
        """Return the answer to a request."""
        assert self.serve is not None
        return Future(self.serve(request))


@dataclass
class Service:
    """Service of the node, with the answers it has sent."""

    ask: Callable[[Trigger.Request, Trigger.Response], Trigger.Response]
    sent: list[Reply] = field(default_factory=list)

    def send_response(self, response: Trigger.Response, _: object) -> None:
        """Keep an answer."""
        self.sent.append(Reply(response.success, response.message))

    def call(self) -> None:
        """Ask, as a client does."""
        self.send_response(self.ask(Trigger.Request(), Trigger.Response()), None)


@dataclass
class Publisher:
    """Publisher that hands every message on."""

    take: Callable[[object], None]
    topic_name: str = ""

    def publish(self, message: object) -> None:
        """Hand a message on."""
        self.take(message)

    def get_subscription_count(self) -> int:
        """Return one reader."""
        return 1


class RoomNode(StandInNode):
    """A node whose topics and services are those of the room."""

    def __init__(self, name: str, given: dict[str, object], servers: Servers) -> None:
        super().__init__(name, given)
        self._servers = servers
        self.services: dict[str, Service] = {}
        self.timers: list[tuple[float, Callable[[], None]]] = []
        self.takers: dict[str, Callable[[object], None]] = {}
        self.published: dict[str, list[object]] = {}
        self.writers: dict[str, tuple[str, ...]] = {}
        self.pose_readers = [Reader("crazyflie_server", POSES_OUT)]
        self.forward: dict[str, Callable[[object], None]] = {}
        self.lines: list[str] = []

    def create_service(self, kind: type, name: str, ask: Callable[..., Trigger.Response]) -> Service:
        """Return a service that tests can call."""
        super().create_service(kind, name, ask)
        made = Service(ask)
        made.send_response = made.send_response  # an attribute of its own, as rclpy's may be replaced
        return self.services.setdefault(name.removeprefix("~/"), made)

    def create_client(self, kind: type, name: str) -> Client:
        """Return a client of the server of that name, or of nobody."""
        super().create_client(kind, name)
        return Client(name, self._servers.get(name))

    def create_publisher(self, kind: type, topic: str, qos: object) -> Publisher:
        """Return a publisher whose messages are kept, or forwarded."""
        super().create_publisher(kind, topic, qos)
        kept = self.published.setdefault(topic, [])

        def take(message: object) -> None:
            self.forward.get(topic, kept.append)(message)

        return Publisher(take, topic)

    def create_subscription(
        self, kind: type, topic: str, receive: Callable[..., None], qos: object, **_: object
    ) -> object:
        """Keep who takes a topic."""
        self.takers[topic] = receive
        return super().create_subscription(kind, topic, receive, qos)

    def get_publishers_info_by_topic(self, topic: str) -> list[Writer]:
        """Return which nodes write a topic."""
        return [Writer(name) for name in self.writers.get(topic.removeprefix("/"), ())]

    def get_subscriptions_info_by_topic(self, _: str) -> list[Reader]:
        """Return which nodes read the filtered poses."""
        return self.pose_readers

    def create_timer(self, period: float, act: Callable[[], None], **_: object) -> None:
        """Keep a timer for the room to call."""
        self.timers.append((period, act))

    def get_clock(self) -> Clock:
        """Return the wall clock."""
        return Clock()

    def get_logger(self) -> "RoomNode":
        """Return the node itself, which keeps the lines."""
        return self

    def info(self, line: str, **_: object) -> None:
        """Keep a line."""
        self.lines.append(line)

    warning = error = info

    def answer(self, call: str) -> str:
        """Return the reason in the answer to a call of the procedure."""
        self.services[call].call()
        return self.services[call].sent[-1].reason

    def report(self) -> None:
        """Let the node report its health, as once per second."""
        (report,) = [act for period, act in self.timers if period == PERIOD_S]
        report()

    @property
    def graded(self) -> tuple[Level, str]:
        """Return level and summary of the last report."""
        last = self.published["/diagnostics"][-1]
        assert isinstance(last, DiagnosticArray)
        return Level(int.from_bytes(last.status[0].level)), last.status[0].message
