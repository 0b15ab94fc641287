"""Stand-in for a ROS node that records the interface a block declares on it, without communication.

A block built on a StandInNode declares, subscribes, publishes and serves as in flight, so its interface is
known without a graph and without waiting.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from q2q_model.ros.node.node_parameters import UNBOUNDED
from q2q_model.tunable import LARGEST_INTEGER, ParameterValue

Receive = Callable[..., None]


@dataclass(frozen=True, slots=True)
class RecordedPort:
    """One topic or service of a node."""

    direction: str
    """reads, publishes, serves or calls."""
    name: str
    kind: str
    """package/msg/Type or package/srv/Type."""
    quality: str
    """Description of the quality of service; empty for a service."""


@dataclass(frozen=True, slots=True)
class Declared:
    """One declared parameter."""

    name: str
    default: object
    description: str
    """Description with unit."""
    allowed: str
    """Description of the allowed values; empty for any of its type."""
    read_only: bool


@dataclass(frozen=True, slots=True)
class Valued:
    """Result of `declare_parameter`."""

    value: object


@dataclass(frozen=True, slots=True)
class Update:
    """Parameter set in flight."""

    name: str
    value: object


class NullEntity:
    """Publisher, reader, logger or timer that does nothing."""

    topic_name = ""

    def publish(self, _: object) -> None:
        """Ignore a message."""

    def send_response(self, _: object, __: object) -> None:
        """Ignore an answer."""

    def wait_for_all_acked(self, _: object = None) -> bool:
        """Return at once: nothing was sent."""
        return True

    def get_subscription_count(self) -> int:
        """Return one, so that publishers do not skip their messages."""
        return 1

    def get_publisher_count(self) -> int:
        """Return one, so that nobody waits for a publisher."""
        return 1

    def info(self, _: str, **__: object) -> None:
        """Ignore a line."""

    def error(self, _: str, **__: object) -> None:
        """Ignore a line."""

    def warning(self, _: str, **__: object) -> None:
        """Ignore a line."""


class StandInNode:
    """Declared parameters, recorded ports and callbacks of subscriptions."""

    def __init__(self, name: str, given: Mapping[str, ParameterValue]) -> None:
        """Take the node's name and the parameters a user would have set."""
        self._name = name
        self._given = given
        self.context = NullEntity()
        self.ports: list[RecordedPort] = []
        self.parameters: list[Declared] = []
        self.readers: list[tuple[type, Receive]] = []
        self._parameters: dict[str, Parameter] = {}
        self._changed: list[Callable[[list[Update]], SetParametersResult]] = []

    def create_publisher(self, kind: type, topic: str, qos: QoSProfile | int) -> NullEntity:
        """Record a published topic."""
        self.ports.append(RecordedPort("publishes", topic, type_name(kind, "msg"), qos_text(qos)))
        return NullEntity()

    def create_subscription(
        self, kind: type, topic: str, receive: Receive, qos: QoSProfile | int, **_: object
    ) -> NullEntity:
        """Record a subscribed topic and its callback."""
        self.ports.append(RecordedPort("reads", topic, type_name(kind, "msg"), qos_text(qos)))
        self.readers.append((kind, receive))
        return NullEntity()

    def create_service(self, kind: type, name: str, _: Receive) -> NullEntity:
        """Record a service."""
        self.ports.append(RecordedPort("serves", name, type_name(kind, "srv"), ""))
        return NullEntity()

    def create_client(self, kind: type, name: str) -> NullEntity:
        """Record a service client."""
        self.ports.append(RecordedPort("calls", name, type_name(kind, "srv"), ""))
        return NullEntity()

    def create_timer(self, _: float, __: Callable[[], None], **___: object) -> None:
        """Return a timer that never fires."""

    def resolve_topic_name(self, topic: str) -> str:
        """Return the name of a topic in the root namespace."""
        return f"/{topic}"

    def get_publishers_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
        """Return no publishers: no other node is known."""
        return []

    def get_subscriptions_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
        """Return no subscriptions: no other node is known."""
        return []

    def count_publishers(self, topic: str) -> int:
        """Return how many publish a topic."""
        return len(self.get_publishers_info_by_topic(topic))

    def declare_parameter(self, name: str, default: object, descriptor: ParameterDescriptor) -> Valued:
        """Record a parameter; return the user's value, else its default."""
        self.parameters.append(
            Declared(
                name,
                default,
                descriptor.description,
                allowed_values_text(descriptor),
                bool(descriptor.read_only),
            )
        )
        fallback = default if isinstance(default, bool | int | float | str | list) else None
        return Valued(self._given.get(name, fallback))

    def add_on_set_parameters_callback(self, changed: Callable[[list[Update]], SetParametersResult]) -> None:
        """Record a callback for parameters set in flight."""
        self._changed.append(changed)

    def is_settable(self, name: str) -> bool:
        """Return whether a parameter takes effect in flight: whether the node refuses an invalid value."""
        return any(_refuses(changed, Update(name, None)) for changed in self._changed)

    def get_logger(self) -> NullEntity:
        """Return a logger without output."""
        return NullEntity()

    def get_name(self) -> str:
        """Return the node's name."""
        return self._name

    def get_fully_qualified_name(self) -> str:
        """Return the node's name in the root namespace."""
        return f"/{self._name}"


def _refuses(changed: Callable[[list[Update]], SetParametersResult], update: Update) -> bool:
    try:
        return not changed([update]).successful
    except TypeError:
        return True


def allowed_values_text(descriptor: ParameterDescriptor) -> str:
    """Return a description of a parameter's allowed values; empty for any of its type."""
    if descriptor.additional_constraints:
        return str(descriptor.additional_constraints)
    for bounds in (*descriptor.floating_point_range, *descriptor.integer_range):
        low, high = bounds.from_value, bounds.to_value
        if high >= UNBOUNDED or high >= LARGEST_INTEGER:
            return f"{low:g} or more"
        return f"up to {high:g}" if low <= -UNBOUNDED else f"{low:g} to {high:g}"
    return ""


def type_name(kind: type, folder: str) -> str:
    """Return package/msg/Type of a generated class."""
    return f"{kind.__module__.partition('.')[0]}/{folder}/{kind.__name__}"


def qos_text(qos: QoSProfile | int) -> str:
    """Return a description of a quality of service; a bare depth is reliable and volatile, as in rclpy."""
    if isinstance(qos, int):
        return f"reliable, volatile, depth {qos}"
    policies = ", ".join(one.name.lower().replace("_", " ") for one in (qos.reliability, qos.durability))
    return f"{policies}, depth {qos.depth}"
