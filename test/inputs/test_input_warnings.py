"""What a node says of input that is of no use to it; it goes on with the rest."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node

from q2q_model.counted import MOST_NAMES
from q2q_model.diagnostics.health import Health
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.ros.mocap_filter_node import CHANGING_NAMES, warning_log
from q2q_model.ros.node.diagnostics_publisher import MOST_WARNINGS
from q2q_model.ros.node.input_warnings import (
    AbsentNames,
    StalledStampWarning,
    warn_of_missing_names,
    warn_of_unknown_names,
)
from q2q_model.ros.topics.vehicle_publishers import VehiclePublishers
from q2q_model.signals.stamps import STALLED
from q2q_model.signals.values import MocapFrame
from q2q_sim.processes.domain import own_domain


class Log:
    """Log that keeps its warnings."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    def warning(self, text: str, *, once: bool = False) -> None:
        """Keep a warning."""
        if not (once and text in self.warnings):
            self.warnings.append(text)


@pytest.fixture
def node() -> Iterator[Node]:
    with own_domain():
        rclpy.init(args=[])
        try:
            made, log = Node("mocap_filter"), Log()
            made.get_logger = lambda: log
            yield made
        finally:
            rclpy.try_shutdown()


def frame(*names: str) -> MocapFrame:
    return MocapFrame(0.0, names, np.zeros((len(names), 3)), np.zeros((len(names), 4)))


def level(t: float, *names: str) -> MocapFrame:
    """Return a frame of level vehicles, which move a little."""
    return replace(
        frame(*names), t=t, pos=np.full((len(names), 3), t * 0.01), quat=identity_quat((len(names),))
    )


def warnings(node: Node) -> list[str]:
    found: list[str] = node.get_logger().warnings
    return found


def test_a_name_that_cannot_begin_a_topic_has_no_topics_and_the_others_have(node: Node) -> None:
    writers = VehiclePublishers(node, {"pose": PoseStamped}, 10.0, ("cf-1", "", "2cf", "né", "c" * 300))
    for _ in range(6):
        writers.create_next(("cf-1", "wand 1", "cf2"))
    made = {one.topic_name for one in node.publishers}
    assert "/cf2/pose" in made
    assert not made & {"/pose", "/cf-1/pose"}
    assert len(warnings(node)) == 6
    assert "'cf-1'/pose" in warnings(node)[0]
    assert max(map(len, warnings(node))) < 120


def test_it_says_nothing_of_topics_that_are_switched_off(node: Node) -> None:
    VehiclePublishers(node, {"pose": PoseStamped}, 0.0, ("cf-1",))
    assert warnings(node) == []


def test_names_that_are_not_of_vehicles_are_reported_once(node: Node) -> None:
    warn = warn_of_unknown_names(node, "mocap", ("cf1", "cf2"))
    for names in (("cf1",), ("cf1", "wand"), ("cf2", "cf1"), ("wand", "cf1")):
        warn(0, frame(*names))
    assert warnings(node) == ["mocap: wand ignored: the vehicles are cf1, cf2"]


def test_without_vehicles_every_name_is_one(node: Node) -> None:
    warn_of_unknown_names(node, "mocap", ())(0, frame("wand"))
    assert warnings(node) == []


def test_vehicles_that_a_topic_lacks_are_reported_once(node: Node) -> None:
    warn = warn_of_missing_names(node, "state", ("CF1", "cf2"))
    for names in (("cf1", "cf2"), ("cf2", "cf1"), ("cf1", "cf2")):
        warn(0, frame(*names))
    assert warnings(node) == ["state: CF1 missing: it has cf1, cf2"]


def test_setpoints_of_vehicles_that_no_state_has_are_reported_once_and_only_after_a_state(node: Node) -> None:
    names = AbsentNames(
        node, "state", "reference_safe: {}: check that the plan is for these vehicles", Health()
    )
    names.update(0, frame("cf7", "cf1"))
    assert warnings(node) == []
    for measured in (("cf1", "cf2"), ("cf1", "cf2"), ("cf2", "cf1"), ("cf1", "cf2", "cf7")):
        names.take_source(measured)
        names.update(0, frame("cf7", "cf1"))
    message = (
        "reference_safe: cf7 not in state, which has cf1, cf2: check that the plan is for these vehicles"
    )
    assert warnings(node) == [message]


def test_unknown_names_that_change_for_ever_are_reported_a_bounded_number_of_times(node: Node) -> None:
    warn = warn_of_unknown_names(node, "mocap", ("cf1",))
    absent = AbsentNames(node, "state", "reference_safe: {}", Health())
    absent.take_source(("cf1",))
    for k in range(5 * MOST_WARNINGS):
        warn(0, frame("cf1", f"m{k}"))
        absent.update(0, frame("cf1", f"m{k}"))
    found = warnings(node)
    assert sum(one.startswith("mocap: ") for one in found) == MOST_WARNINGS
    assert sum(one.startswith("reference_safe: ") for one in found) == MOST_WARNINGS


def test_the_vehicle_that_stays_missing_is_reported_after_the_others_came_one_by_one(node: Node) -> None:
    vehicles = tuple(f"cf{k:02d}" for k in range(2 * MOST_WARNINGS))
    warn = warn_of_missing_names(node, "state", vehicles)
    for k in range(1, len(vehicles)):
        warn(0, frame(*vehicles[:k]))
    assert warnings(node)[-1].startswith(f"state: {vehicles[-1]} missing: ")


def test_of_many_names_the_first_are_listed_and_the_others_counted(node: Node) -> None:
    names, health = tuple(f"m{k:05d}" for k in range(10_000)), Health()
    absent = AbsentNames(node, "state", "reference_safe: {}", health)
    absent.take_source(("cf1", *names[:MOST_NAMES]))
    absent.update(0, frame(*names[: MOST_NAMES + 1]))
    assert health.doubts["state's vehicles"].endswith(f", {names[MOST_NAMES - 2]}, and 1 more")
    assert health.doubts["state's vehicles"].startswith(f"{names[MOST_NAMES]} not in state, which has cf1, m")
    warn_of_unknown_names(node, "mocap", ("cf1",))(0, frame(*names))
    warn_of_missing_names(node, "state", names)(0, frame(*names[:-MOST_NAMES]))
    _, unknown, missing = warnings(node)
    first = ", ".join(names[:MOST_NAMES])
    assert unknown == f"mocap: {first}, and 9980 more ignored: the vehicles are cf1"
    assert missing == f"state: {', '.join(names[-MOST_NAMES:])} missing: it has {first}, and 9960 more"


def test_stamps_that_stand_still_are_reported_once_and_moving_ones_never(node: Node) -> None:
    health = Health()
    stamps = StalledStampWarning(node, "mocap", health)
    for stamp_ns in range(2 * STALLED):
        stamps.update(stamp_ns, frame("cf1"))
    assert (warnings(node), [*health.doubts.values()]) == ([], [""])
    for _ in range(3 * STALLED):
        stamps.update(0, frame("cf1"))
    message = f"mocap: {STALLED} frames stamped 0 s: stamp each with its time of capture"
    assert (warnings(node), [*health.doubts.values()]) == ([message], [message])
    stamps.update(1, frame("cf1"))
    assert [*health.doubts.values()] == [""]


def test_names_that_change_for_ever_are_reported_once_with_the_parameter_to_set(node: Node) -> None:
    block, health = MocapFilter(MocapFilterParams(), ()), Health()
    log = warning_log(node, health, block)
    for tick in range(100):
        log(0, block.update(level(0.01 * tick, "cf1", f"m{tick}")))
    assert warnings(node).count(CHANGING_NAMES) == 1
    assert "parameter vehicles" in health.doubts["names"]
    log(0, block.update(level(1.0, "cf1")))
    assert health.doubts["names"] == ""
