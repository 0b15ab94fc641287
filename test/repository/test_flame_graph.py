"""Flame graphs count every sample once, within the loop of the flight, below the node that ran it."""

import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest

from flame_graph.drawing import LEAST, WIDTH, boxes, flame_graph
from flame_graph.frame_tree import busiest, frame_tree

LINES = (
    "main (q2q_control/ros/pid_node.py:9);_spin (q2q_model/ros/node/run.py:1);step (a.py:1) 6",
    "main (q2q_control/ros/pid_node.py:9);_spin (q2q_model/ros/node/run.py:1);step (a.py:1);add (b.py:2) 3",
    "main (q2q_sim/ros/simulator_node.py:9);_spin (q2q_model/ros/node/run.py:1);step (a.py:1) 1",
    "main (q2q_sim/ros/simulator_node.py:9);load (c.py:1) 50",
)


def test_samples_outside_the_root_are_left_out_and_those_within_are_below_their_node():
    tree = frame_tree(LINES, "_spin")
    assert tree.samples == 10
    assert {name: one.samples for name, one in tree.calls.items()} == {"pid": 9, "simulator": 1}
    step = tree.calls["pid"].calls["step (a.py:1)"]
    assert (step.samples, step.own) == (9, 6)


def test_the_busiest_functions_share_all_samples():
    shares = dict(busiest(frame_tree(LINES, "_spin")))
    assert shares["step (a.py:1)"] == pytest.approx(0.7)
    assert shares["add (b.py:2)"] == pytest.approx(0.3)
    assert sum(shares.values()) == pytest.approx(1.0)


def test_a_root_that_was_never_running_is_refused():
    with pytest.raises(ValueError, match="no stack within fly"):
        frame_tree(LINES, "fly")


def test_boxes_lie_within_their_callers_and_small_ones_are_left_out():
    lines = [*LINES, "_spin (r.py:1);rare (d.py:1) 1", "_spin (r.py:1);often (d.py:1) 5000"]
    tree = frame_tree(lines, "_spin")
    drawn = list(boxes(tree, tree.samples))
    names = {box.name for box in drawn}
    assert "often (d.py:1)" in names
    assert "rare (d.py:1)" not in names
    assert all(box.share >= LEAST for box in drawn)
    for outer, inner in pairwise(drawn):
        if inner.level > outer.level:
            assert outer.left <= inner.left <= inner.left + inner.share <= outer.left + outer.share + 1e-12


def test_the_drawing_is_xml_whose_boxes_have_the_width_of_their_share():
    picture = ET.fromstring(flame_graph(frame_tree(LINES, "_spin"), "a <title>"))  # noqa: S314 (our own)
    space = {"svg": "http://www.w3.org/2000/svg"}
    groups = {
        group.findtext("svg:title", namespaces=space): group for group in picture.findall("svg:g", space)
    }
    box = groups["add (b.py:2): 30.0 %"].find("svg:rect", space)
    assert box is not None
    assert float(box.attrib["width"]) == pytest.approx(0.3 * WIDTH)
