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

from q2q_control.radio.link.vehicle_link import LinkHealth
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.ready import offer_drained, offer_ready
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_sim.q2q_packages import PACKAGES
from q2q_sim.ros.absent_packages import standing_in
from q2q_sim.ros.node_configurations import VEHICLE, Configuration, configurations, write_start_files
from q2q_sim.ros.required_parameters import required_parameters
from q2q_sim.ros.stand_in import Declared, RecordedPort, StandInNode
from q2q_sim.ros.surveyed_ports import surveyed_ports


@dataclass(frozen=True, slots=True)
class SurveyedParameter:
    """Parameter of a node."""

    declared: Declared
    settable: bool
    """Whether it takes effect in flight."""
    requires: str
    """Parameters without which the node does not declare it; empty for none."""


@dataclass(frozen=True, slots=True)
class NodeInterface:
    """Parameters, topics and services of a node."""

    package: str
    executable: str
    description: str
    """The node module's docstring."""
    ports: tuple[tuple[RecordedPort, str], ...]
    """Each with the parameters it requires; empty for always."""
    parameters: tuple[SurveyedParameter, ...]


def survey() -> list[NodeInterface]:
    """Return the interface of every node, by package and executable."""
    return [_surveyed(package, module) for package in PACKAGES for module in node_modules(package)]


def node_modules(package: str) -> list[str]:
    """Return the executable node modules of a package, sorted."""
    path = import_module(f"{package}.ros").__path__
    named = sorted(found.name for found in iter_modules(path) if found.name.endswith("_node"))
    with standing_in():
        return [name for name in named if "main" in vars(import_module(f"{package}.ros.{name}"))]


class _SilentLink:
    """Radio link to a vehicle that never connects."""

    pose = None

    def __init__(self, *_: object, **__: object) -> None:
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
        write_start_files(folder)
        chosen = configurations(executable, folder)
        built = [_built(module, executable, configuration) for configuration in chosen]
    return NodeInterface(
        package=package,
        executable=executable,
        description=(module.__doc__ or "").strip(),
        ports=tuple(surveyed_ports(built, chosen)),
        parameters=tuple(_parameters(built, chosen)),
    )


def _parameters(built: list[StandInNode], chosen: list[Configuration]) -> list[SurveyedParameter]:
    """Return every parameter once, as the last configuration that has it declares it."""
    required = required_parameters([[one.name for one in node.parameters] for node in built], chosen)
    found = {one.name: (one, node.is_settable(one.name)) for node in built for one in node.parameters}
    return [SurveyedParameter(*found[name], requires) for name, requires in required.items()]


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
