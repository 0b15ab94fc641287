"""No message, timer or service call ends a node: every input of every node is given what it should not get.

A subscription of a message that SPOILED does not know, or one that no node here makes, fails the test.
"""

import ast
import math
import struct
import sys
import warnings
from array import array
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from drawn_values import VEHICLES
from fresh_checkout import ROOT

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from q2q_msgs.msg import Plan, Prediction
from rclpy.clock import Clock
from std_msgs.msg import String

from q2q_model.model_files.find_model import find_model
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.diagnostics_publisher import PERIOD_S
from q2q_model.ros.online_identification import OnlineIdentification
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_sim.ros import node_survey
from q2q_sim.ros.node_configurations import Configuration, configurations
from q2q_sim.ros.node_survey import PACKAGES, node_modules
from q2q_sim.ros.stand_in import NullEntity, StandInNode

NODES = [(package, name) for package in PACKAGES for name in node_modules(package)]
TOOLS = {"flight_director.py", "stand_in.py"}
"""Files of no node: a tool that starts nodes, and the stand-in that this test is built on."""
KINDS = {message: kind for kind, message in MESSAGES.items()}
SECOND = 10**9
FIRST, LAST = -(2**31), 2**31 - 1
"""Ends of a message's seconds, an int32."""


def tick(kind: type[Signal], stamp_ns: int = SECOND, names: tuple[str, ...] = VEHICLES) -> bytes:
    return encode(synthetic_signal(kind, 1e-9 * stamp_ns, names), stamp_ns)


def stamped(kind: type[Signal], sec: int, nanosec: int) -> bytes:
    return tick(kind)[:4] + struct.pack("<iI", sec, nanosec) + tick(kind)[12:]


def filled(kind: type[Signal], value: float) -> bytes:
    """Return a message whose every number is `value`, its status one that does not exist."""
    usual = synthetic_signal(kind, 1.0, VEHICLES)
    rows = {one.attribute: getattr(usual, one.attribute) for one in LAYOUTS[kind].columns}
    columns = {name: np.full_like(old, 255 if old.dtype == np.uint8 else value) for name, old in rows.items()}
    return encode(kind(t=1.0, names=VEHICLES, **columns), SECOND)


INVALID: dict[str, Callable[[type[Signal]], bytes]] = {
    "empty": lambda _: b"",
    "a header only": lambda kind: tick(kind)[:12],
    "cut": lambda kind: tick(kind)[:-9],
    "a name twice": lambda kind: tick(kind).replace(b"cf2", b"cf1"),
    "a second of nanoseconds": lambda kind: stamped(kind, 1, SECOND),
    "the last stamp": lambda kind: stamped(kind, LAST, 2**32 - 1),
    "the first stamp": lambda kind: stamped(kind, FIRST, 0),
}
"""Bytes that every node refuses, and says so."""
INVALID_HEADERS = ("empty", "a second of nanoseconds", "the last stamp", "the first stamp")
HEADERS_ONLY = {"bag_play_node", "bag_record_node"}
"""Nodes that read no more of a message than its stamp."""

ABSURD: dict[str, Callable[[type[Signal]], bytes]] = {
    "before zero": lambda kind: stamped(kind, -1, 5),
    "no vehicles": lambda kind: tick(kind, names=()),
    "many vehicles": lambda kind: tick(kind, names=tuple(f"v{row}" for row in range(100))),
    "a long name": lambda kind: tick(kind, names=("x" * 20_000, "cf1")),
    "names of no topic": lambda kind: tick(kind, names=("ü/é\n", "", "a\0b")),
    "no numbers": lambda kind: filled(kind, math.nan),
    "infinite": lambda kind: filled(kind, math.inf),
    "huge": lambda kind: filled(kind, 1e300),
}
"""Ticks that a node may take."""


def plans() -> list[Plan]:
    none, huge = Plan(), Plan(names=["cf1"], pieces=[1], order=2, durations=[1.0], coefficients=[1e300] * 8)
    huge.header.stamp.sec = LAST
    unordered = Plan(names=["cf1"], pieces=[1], order=0, durations=[1.0])
    endless = Plan(names=["cf1"], pieces=[1], order=1, durations=[1e300], coefficients=[0.0] * 4)
    named = Plan(names=["", "é" * 9000], pieces=[1, 1], order=1, durations=[1.0] * 2, coefficients=[0.0] * 8)
    return [none, huge, unordered, endless, named]


def predictions() -> list[Prediction]:
    still = array("f", [0.0] * 12)
    found = [Prediction(), Prediction(names=["cf1"], step=0.0)]
    for names in (["cf2"], ["cf2", "cf2"], ["é" * 9000]):
        for start, step in ((0.0, 1e-300), (-1e18, 0.05), (math.nan, 0.05), (0.0, math.inf), (0.0, 0.05)):
            found.append(Prediction(names=names, start=start, step=step, position=still))
    far = Prediction(names=["cf2"], step=0.05, position=array("f", [3e38, -3e38] * 6))
    late = Prediction(names=["cf1"], step=0.05, position=still)
    late.header.stamp.sec, late.header.stamp.nanosec = LAST, 2**32 - 1
    return [*found, far, late]


def poses() -> list[SimpleNamespace]:
    bad = SimpleNamespace(x=math.nan, y=math.inf, z=1e300, w=math.nan)
    one = SimpleNamespace(name="cf1", pose=SimpleNamespace(position=bad, orientation=bad))
    stamps = [SimpleNamespace(sec=sec, nanosec=nano) for sec, nano in ((LAST, 2**32 - 1), (FIRST, 0), (1, 0))]
    heads = [SimpleNamespace(stamp=stamp) for stamp in stamps]
    return [SimpleNamespace(header=head, poses=some) for head in heads for some in ([], [one], [one, one])]


SPOILED: dict[str, Callable[[], list[object]]] = {
    "Plan": plans,
    "Prediction": predictions,
    "String": lambda: [String(), String(data="[" * 100_000), String(data='{"format": "q2q-model"}')],
    "DiagnosticStatus": lambda: [
        DiagnosticStatus(message=step) for step in ("", "é" * 9000, "hover", "flight")
    ],
    "NamedPoseArray": poses,
    "Status": lambda: [SimpleNamespace(supervisor_info=65535, battery_voltage=math.nan)],
    "LogDataGeneric": lambda: [SimpleNamespace(values=values) for values in ([], [math.nan] * 3, [1.0] * 9)],
}
"""Messages of each type that is not read as bytes."""


class Alive(NullEntity):
    """Context that runs, timer, and link to a vehicle, which does nothing."""

    def __getattr__(self, _: str) -> Callable[..., bool]:
        """Return a method that does nothing."""
        return lambda *_: True


class Nobody(Alive):
    """Client of a service that nobody serves."""

    def __init__(self, name: str) -> None:
        self.srv_name = name

    def service_is_ready(self) -> bool:
        """Return False: nobody does."""
        return False


class Open(StandInNode):
    """A stand-in node whose inputs can all be given something."""

    sites: set[tuple[str, str]] = set()  # noqa: RUF012  of all nodes
    """File and function of every subscription made."""

    def __init__(self, name: str, given: Configuration) -> None:
        super().__init__(name, {"poses_in": "/poses", "stamps": "header"} | given)
        self.context = Alive()
        self.inputs: list[tuple[str, type, Callable[[object], None]]] = []
        self.timers: list[tuple[float, Callable[[], None]]] = []
        self.services: list[tuple[type, Callable[..., object]]] = []
        self.reports: list[DiagnosticArray] = []
        self.publishers = self.subscriptions = ()

    def create_publisher(self, kind: type, topic: str, qos: object) -> NullEntity:
        """Return a publisher; reports of health are kept."""
        made = super().create_publisher(kind, topic, qos)
        if topic == "/diagnostics":
            made.publish = self.reports.append
        return made

    def create_subscription(
        self, kind: type, topic: str, receive: Callable[..., None], qos: object, **_: object
    ) -> NullEntity:
        """Keep who takes a topic."""
        caller = sys._getframe(1).f_code
        self.sites.add((Path(caller.co_filename).name, caller.co_name))
        self.inputs.append((topic, kind, receive))
        return super().create_subscription(kind, topic, receive, qos)

    def create_timer(self, period: float, act: Callable[[], None], **_: object) -> Alive:
        """Keep a timer."""
        self.timers.append((period, act))
        return Alive()

    def create_service(self, kind: type, name: str, ask: Callable[..., object]) -> NullEntity:
        """Keep a service."""
        self.services.append((kind, ask))
        return super().create_service(kind, name, ask)

    def create_client(self, kind: type, name: str) -> Nobody:
        """Return a client of nobody."""
        super().create_client(kind, name)
        return Nobody(name)

    def get_clock(self) -> Clock:
        """Return a clock."""
        return Clock()

    def act(self) -> None:
        """Let every timer fire, and call every service twice."""
        for _, fire in self.timers:
            fire()
        for kind, ask in 2 * self.services:
            ask(kind.Request(), kind.Response())

    def refused(self) -> int:
        """Return how many messages `/diagnostics` says were refused."""
        for period, fire in self.timers:
            if period == PERIOD_S:
                fire()
        return sum(int(one.value) for one in self.reports[-1].status[0].values if one.key == "refused")


def give_everything(node: Open) -> None:
    """Give every input of a node all that is wrong, and good ticks after each."""
    node.act()
    raw = [(topic, KINDS[kind], take) for topic, kind, take in node.inputs if kind in KINDS]
    for stamp_ns, make in enumerate([*INVALID.values(), *ABSURD.values()], 2):
        for _, kind, take in raw:
            take(make(kind))
        node.act()
        for _, kind, take in raw:
            take(tick(kind, stamp_ns * SECOND))
    for _, kind, take in node.inputs:
        for message in [] if kind in KINDS else SPOILED[kind.__name__]():
            take(message)
            for _, one, hear in raw:
                hear(tick(one, stamp_ns * SECOND))
    node.act()


def expect_refusals(node: Open, invalid: tuple[str, ...]) -> None:
    """Give invalid bytes to every input of a node, which counts and reports each of them."""
    for topic, kind, take in node.inputs:
        for what in invalid if kind in KINDS else ():
            before = node.refused()
            take(INVALID[what](KINDS[kind]))
            assert node.refused() == before + 1, f"{what} on {topic}"


def extended(executable: str, folder: Path) -> list[Configuration]:
    more: dict[str, list[Configuration]] = {
        "mpc": [{"vehicles": ("cf1",), "distributed": True, "live": True}],
        "simulator": [{"autostart": True}],
    }
    return configurations(executable, folder) + more.get(executable, [])


def feed(monkeypatch: pytest.MonkeyPatch, package: str, name: str, give: Callable[[Open], None]) -> None:
    """Build a node in every configuration, and give it something before it ends."""
    for attribute, value in (("StandInNode", Open), ("_feed", give), ("configurations", extended)):
        monkeypatch.setattr(node_survey, attribute, value)
    monkeypatch.setitem(
        node_survey.HARDWARE,
        "radio",
        (*node_survey.HARDWARE["radio"][:2], type("Link", (node_survey._SilentLink, Alive), {})),
    )
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        node_survey._surveyed(package, name)


@pytest.mark.parametrize(("package", "name"), NODES)
def test_nothing_that_comes_in_ends_a_node_and_invalid_bytes_are_reported(
    monkeypatch: pytest.MonkeyPatch, package: str, name: str
) -> None:
    def give(node: Open) -> None:
        expect_refusals(node, INVALID_HEADERS if name in HEADERS_ONLY else tuple(INVALID))
        give_everything(node)

    feed(monkeypatch, package, name, give)


def identification() -> Open:
    node = Open("identify", {})
    OnlineIdentification(node, find_model("paper_law"), vehicle_by_name("crazyflie_2_0"))
    return node


def test_nothing_that_comes_in_ends_an_online_identification() -> None:
    with np.errstate(all="ignore"):
        give_everything(identification())


def test_the_nodes_here_make_every_subscription_of_q2q(monkeypatch: pytest.MonkeyPatch) -> None:
    identification()
    for package, name in NODES:
        feed(monkeypatch, package, name, lambda _: None)
    written = {
        (file.name, part.name)
        for file in ROOT.glob("src/q2q_*/q2q_*/ros/**/*.py")
        for part in ast.walk(ast.parse(file.read_text()))
        if file.name not in TOOLS and isinstance(part, ast.FunctionDef)
        if any(getattr(one, "attr", "") == "create_subscription" for one in ast.walk(part))
    }
    assert ("tick_wiring.py", "_subscribe") in written
    assert written - Open.sites == set()
