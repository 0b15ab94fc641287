"""Survey of q2q's nodes: topics, types, qualities of service, services and parameters of each.

Every module `q2q_*.ros.*_node` is built on a StandInNode by its `main`, once for each of its start
configurations, and given one tick, so that topics of a vehicle appear too. The union is its interface.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from pkgutil import iter_modules
from tempfile import TemporaryDirectory
from types import ModuleType

from q2q_control.radio.link import LinkHealth
from q2q_model.bag import BagWriter
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.ready import offer_drained, offer_ready
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.topic_names import TICK_TOPICS
from q2q_model.trajectory import plan_file
from q2q_model.tunable import ParameterValue
from q2q_sim.bag_topics.topics import TYPE_NAMES
from q2q_sim.loop import flight_blocks
from q2q_sim.ros.absent_packages import standing_in
from q2q_sim.ros.stand_in import Declared, RecordedPort, StandInNode
from q2q_sim.scenarios import library

PACKAGES = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim")
VEHICLE = "cf1"
"""Example vehicle in the names of topics."""
ANY_VEHICLE = "<name>"
SCENARIO = "table6"

Configuration = dict[str, ParameterValue]


@dataclass(frozen=True, slots=True)
class NodeInterface:
    """Parameters, topics and services of a node."""

    package: str
    executable: str
    description: str
    """The node module's docstring."""
    ports: tuple[tuple[RecordedPort, str], ...]
    """Each with the parameters it requires; empty for always."""
    parameters: tuple[tuple[Declared, bool], ...]
    """Each with whether it takes effect in flight."""


def survey() -> list[NodeInterface]:
    """Return the interface of every node, by package and executable."""
    return [_surveyed(package, module) for package in PACKAGES for module in node_modules(package)]


def node_modules(package: str) -> list[str]:
    """Return the executable node modules of a package, sorted."""
    path = import_module(f"{package}.ros").__path__
    named = sorted(found.name for found in iter_modules(path) if found.name.endswith("_node"))
    with standing_in():
        return [name for name in named if "main" in vars(import_module(f"{package}.ros.{name}"))]


def configurations(executable: str, folder: Path) -> list[Configuration]:
    """Return start configurations of a node that differ in topics or parameters, with files in `folder`."""
    played: Configuration = {"bag": str(folder / "bag")}
    unanswered: Configuration = played | {"topics": tuple(one for one in TICK_TOPICS if one != "command")}
    known: dict[str, list[Configuration]] = _flying_configurations() | {
        "interference": [{"correct_vehicle": "none"}, {"correct_vehicle": "crazyflie_2_0"}],
        "trajectory": [
            {"plan": str(folder / "plan.json"), "wait": True},
            {"plan": str(folder / "plan.json"), "wait": False},
        ],
        "replanner": [{"law": "paper"}, {"law": "safe"}],
        "simulator": [{"crtp": False}, {"crtp": True, "crtp_port": 0}],
        "bag_record": [{"bag": str(folder / "made")}],
        "bag_play": [
            played | {"answer": "", "clock": False},
            unanswered | {"answer": "command", "clock": False},
            unanswered | {"answer": "", "clock": False},
            unanswered | {"answer": "", "clock": True},
        ],
    }
    return known.get(executable, [{}])


def _flying_configurations() -> dict[str, list[Configuration]]:
    """Return those of the controllers, and of the nodes that reach real vehicles."""
    link: Configuration = {"vehicles": (VEHICLE,), "uris": ("udp://127.0.0.1:19850",)}
    of_one: Configuration = {"vehicles": (VEHICLE,)}
    return {
        "pid": [
            {"aware": True, "live": True, "correct": False},
            {"aware": False, "live": True, "correct": False},
            {"aware": True, "live": True, "correct": True},
        ],
        "mpc": [
            of_one | {"correct": False, "distributed": False},
            of_one | {"correct": True, "distributed": False},
            of_one | {"correct": False, "distributed": True},
        ],
        "radio": [
            link | {"mode": "command"},
            link | {"mode": "setpoint", "aware": True},
            link | {"mode": "setpoint", "aware": False},
        ],
        "crazyswarm": [
            of_one | {"mode": "setpoint", "poses_out": "/poses_filtered", "aware": True},
            of_one | {"mode": "setpoint", "poses_out": "", "aware": True},
            of_one | {"mode": "setpoint", "poses_out": "/poses_filtered", "aware": False},
            of_one | {"mode": "command", "poses_out": ""},
        ],
    }


class _SilentLink:
    """Radio link to a vehicle that never connects."""

    pose = None

    def __init__(self, *_: object) -> None:
        """Take the arguments of CflibLink."""

    def health(self) -> LinkHealth:
        """Return the health of a link that never connected."""
        return LinkHealth(connected=False)

    def keep_open(self) -> None:
        """Do nothing."""

    def log_lines(self) -> tuple[str, ...]:
        """Return no lines."""
        return ()

    def close(self) -> None:
        """Do nothing."""


HARDWARE = {"radio": ("q2q_control.radio.radio_vehicles", "CflibLink", _SilentLink)}
"""Module and name of a node's class that reaches hardware, and its replacement."""


def _surveyed(package: str, name: str) -> NodeInterface:
    module = import_module(f"{package}.ros.{name}")
    executable = name.removesuffix("_node")
    with TemporaryDirectory(prefix="q2q-survey-") as scratch:
        folder = Path(scratch)
        plan_file.save(folder / "plan.json", flight_blocks.plan_of(library.load(SCENARIO)))
        _write_bag(folder / "bag")
        chosen = configurations(executable, folder)
        built = [_built(module, executable, configuration) for configuration in chosen]
    return NodeInterface(
        package=package,
        executable=executable,
        description=(module.__doc__ or "").strip(),
        ports=tuple(_ports(built, chosen)),
        parameters=tuple(
            {
                one.name: (one, node.is_settable(one.name)) for node in built for one in node.parameters
            }.values()
        ),
    )


def _built(module: ModuleType, executable: str, configuration: Configuration) -> StandInNode:
    """Return the stand-in on which `main` of a node module has built its node, after one tick."""
    node = StandInNode(executable, configuration)
    with ExitStack() as stack:
        stack.enter_context(standing_in())
        if executable in HARDWARE:
            owner, name, stand_in = HARDWARE[executable]
            stack.enter_context(_replaced(import_module(owner), name, stand_in))
        build, *ends = _arguments_of_run(module)
        kept = build(node)
        offer_ready(node)
        offer_drained(node)
        with redirect_stderr(StringIO()):
            _feed(node)
        for end in ends:
            end(kept)
    return node


def _arguments_of_run(module: ModuleType) -> list[Callable[..., object]]:
    """Return the functions that `main` of a node module passes to `run`, without running it."""
    passed: list[Callable[..., object]] = []

    def run(_: str, *functions: Callable[..., object], **__: Callable[..., object]) -> None:
        passed.extend(functions)  # by name: `land`, and nothing flies

    with _replaced(module, "run", run):
        module.main()
    return passed


@contextmanager
def _replaced(module: ModuleType, name: str, stand_in: object) -> Iterator[None]:
    own = vars(module)[name]
    setattr(module, name, stand_in)
    try:
        yield
    finally:
        setattr(module, name, own)


def _feed(node: StandInNode) -> None:
    kinds = {message: kind for kind, message in MESSAGES.items()}
    for message, receive in node.readers:
        if message in kinds:
            receive(encode(synthetic_signal(kinds[message], 0.0, (VEHICLE,)), 0))


def _write_bag(folder: Path) -> None:
    writer = BagWriter(folder)
    for topic, kind in TYPE_NAMES.items():
        writer.add_topic(f"/{topic}", kind)
        writer.write_raw(f"/{topic}", 0, encode(synthetic_signal(TICK_TOPICS[topic], 0.0, (VEHICLE,)), 0))
    writer.close()


def _ports(built: list[StandInNode], chosen: list[Configuration]) -> list[tuple[RecordedPort, str]]:
    """Return every port once, with the parameters that it requires."""
    owners: dict[RecordedPort, list[Configuration]] = {}
    for node, configuration in zip(built, chosen, strict=True):
        for port in dict.fromkeys(_of_any_vehicle(port) for port in node.ports):
            owners.setdefault(port, []).append(configuration)
    return [
        (port, "" if len(having) == len(chosen) else _distinction(having, chosen))
        for port, having in owners.items()
    ]


def _distinction(having: list[Configuration], chosen: list[Configuration]) -> str:
    """Return the parameters shared by these configurations and no other; empty if there is no other."""
    lacking = [configuration for configuration in chosen if configuration not in having]
    if not lacking:
        return ""
    shared = {key: value for key, value in having[0].items() if all(one.get(key) == value for one in having)}
    distinct = {key: value for key, value in shared.items() if all(one.get(key) != value for one in lacking)}
    return ", ".join(f"`{key}`: {_plain(value)}" for key, value in distinct.items())


def _plain(value: ParameterValue) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _of_any_vehicle(port: RecordedPort) -> RecordedPort:
    if not port.name.startswith(f"{VEHICLE}/"):
        return port
    return RecordedPort(
        port.direction, f"{ANY_VEHICLE}/{port.name.removeprefix(VEHICLE + '/')}", port.kind, port.quality
    )
