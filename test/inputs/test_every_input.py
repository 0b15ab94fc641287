"""No message, timer or service call ends a node: every input of every node is given what it should not get.

A subscription of a message that SPOILED does not know, or one that no node here makes, fails the test.
"""

import ast
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fresh_checkout import ROOT

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from open_nodes import Alive, OpenNode
from spoiled_messages import ABSURD, INVALID, INVALID_HEADERS, KINDS, SECOND, SPOILED, tick

from q2q_model.model_files.find_model import find_model
from q2q_model.ros.online_identification import OnlineIdentification
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_sim.q2q_packages import PACKAGES
from q2q_sim.ros import node_survey
from q2q_sim.ros.node_configurations import Configuration, configurations
from q2q_sim.ros.node_survey import node_modules

NODES = [(package, name) for package in PACKAGES for name in node_modules(package)]
TOOLS = {"flight_director.py", "stand_in.py"}
"""Files of no node: a tool that starts nodes, and the stand-in that this test is built on."""
HEADERS_ONLY = {"bag_play_node", "bag_record_node"}
"""Nodes that read no more of a message than its stamp."""


def give_everything(node: OpenNode) -> None:
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


def expect_refusals(node: OpenNode, invalid: tuple[str, ...]) -> None:
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


def feed(monkeypatch: pytest.MonkeyPatch, package: str, name: str, give: Callable[[OpenNode], None]) -> None:
    """Build a node in every configuration, and give it something before it ends."""
    for attribute, value in (("StandInNode", OpenNode), ("_feed", give), ("configurations", extended)):
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
    def give(node: OpenNode) -> None:
        expect_refusals(node, INVALID_HEADERS if name in HEADERS_ONLY else tuple(INVALID))
        give_everything(node)

    feed(monkeypatch, package, name, give)


def identification() -> OpenNode:
    node = OpenNode("identify", {})
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
    assert written - OpenNode.sites == set()
