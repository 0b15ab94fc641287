"""Nothing that comes in can throw a node out: garbage is refused with a diagnostic, and leaves no trace."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from importlib import import_module
from types import MappingProxyType

import numpy as np
import pytest
from drawn_values import VEHICLES, numbers, words
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import String

from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import SwarmCommand, SwarmImu
from q2q_model.tunable import ParameterValue
from q2q_sim.ros.absent_packages import standing_in
from q2q_sim.ros.stand_in import NullEntity, StandInNode

NODES = (
    "q2q_model.mocap_filter",
    "q2q_model.interference",
    "q2q_planner.replanner",
    "q2q_control.pid",
    "q2q_control.mpc",
)
KINDS = {message: kind for kind, message in MESSAGES.items()}
TICK_NS = 10_000_000


class Ear(NullEntity):
    """Keep what a node publishes."""

    def __init__(self) -> None:
        self.received: list[bytes] = []

    def publish(self, message: object) -> None:
        """Keep a message's bytes."""
        if isinstance(message, bytes):
            self.received.append(message)


class Alive:
    """Stand in for a context that was not shut down."""

    def ok(self) -> bool:
        """Return that ROS runs."""
        return True


class Listening(StandInNode):
    """A stand-in node whose published ticks can be read."""

    context = Alive()

    def __init__(self, name: str, given: Mapping[str, ParameterValue]) -> None:
        super().__init__(name, {"vehicle_topics_hz": 0.0, "legacy_hz": 0.0, **given})
        self.ears: list[Ear] = []

    def create_publisher(self, *_: object) -> Ear:
        """Return an ear in place of a writer."""
        self.ears.append(Ear())
        return self.ears[-1]

    def receivers(self) -> list[tuple[type[Signal], Callable[[bytes], None]]]:
        """Return what signals are read, and by whom."""
        return [(KINDS[message], receive) for message, receive in self.readers if message in KINDS]

    def answer(self, stamp_ns: int) -> list[bytes]:
        """Feed a good tick and return what is published."""
        for ear in self.ears:
            ear.received.clear()
        for kind, receive in self.receivers():
            receive(encode(synthetic_signal(kind, stamp_ns * 1e-9, VEHICLES), stamp_ns))
        return [data for ear in self.ears for data in ear.received]


def built(name: str, given: Mapping[str, ParameterValue] = MappingProxyType({})) -> tuple[Listening, object]:
    package, executable = name.split(".")
    node = Listening(executable, given)
    with standing_in():
        return node, import_module(f"{package}.ros.{executable}_node").build(node)


@cache
def pair(name: str) -> tuple[tuple[Listening, object], tuple[Listening, object], list[int]]:
    """Return two nodes alike, and the last tick they were fed."""
    return built(name), built(name), [0]


@st.composite
def spoiled(draw: st.DrawFn, kind: type[Signal]) -> bytes:
    """Draw the bytes of a message with something wrong in it."""
    data = bytearray(encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9))
    how = draw(st.sampled_from(["cut", "flip", "noise", "longer", "count"]))
    if how == "cut":
        return bytes(data[: draw(st.integers(0, len(data) - 1))])
    if how == "noise":
        return draw(st.binary(max_size=200))
    if how == "longer":
        return bytes(data) + draw(st.binary(min_size=1, max_size=64))
    at = draw(st.integers(0, len(data) - 4)) & ~3
    if how == "count":
        data[at : at + 4] = draw(
            st.sampled_from([b"\xff\xff\xff\xff", b"\x00\x00\x00\x80", b"\x01\x00\x10\x00"])
        )
    else:
        data[at] ^= draw(st.integers(1, 255))
    return bytes(data)


@st.composite
def absurd(draw: st.DrawFn, kind: type[Signal]) -> Signal:
    """Draw a signal that can be said, and makes no sense."""
    names = tuple(draw(st.lists(words, max_size=6, unique=True)))
    columns = {}
    for column in LAYOUTS[kind].columns:
        shape = (len(names),) if column.width == 1 else (len(names), column.width)
        status = column.attribute == "status"
        flat = draw(
            st.lists(
                st.integers(0, 255) if status else numbers,
                min_size=int(np.prod(shape)),
                max_size=int(np.prod(shape)),
            )
        )
        columns[column.attribute] = np.array(flat, dtype=np.uint8 if status else np.float64).reshape(shape)
    return kind(t=0.0, names=names, **columns)


def refused(data: bytes, kind: type[Signal]) -> bool:
    try:
        decode(data, kind)
    except ValueError:
        return True
    return False


@pytest.mark.parametrize("name", NODES)
@settings(max_examples=40, deadline=None, derandomize=True)
@given(data=st.data())
def test_spoiled_bytes_are_counted_and_leave_a_node_as_it_was(name: str, data: st.DataObject) -> None:
    (node, kept), (twin, _), tick = pair(name)
    before = kept.health.refused
    which = data.draw(st.integers(0, len(node.receivers()) - 1))
    kind, receive = node.receivers()[which]
    garbage = data.draw(spoiled(kind))
    if not refused(garbage, kind):
        return
    receive(garbage)
    assert kept.health.refused > before
    assert kept.health.last_refusal
    tick[0] += TICK_NS
    answers = node.answer(tick[0]), twin.answer(tick[0])
    assert len(answers[0]) == len(answers[1]) == 1
    for one, other in zip(*answers, strict=True):
        kind_out = _kind_of(one)
        _same(decode(one, kind_out), decode(other, kind_out))


def wrong_frame(kind: type[Signal]) -> bytes:
    data = encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9)
    assert b"world" in data
    return data.replace(b"world", b"mars!")


def wrong_size(kind: type[Signal]) -> bytes:
    return encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9)[:-9]


def name_twice(kind: type[Signal]) -> bytes:
    return encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9).replace(b"cf2", b"cf1")


def unequal_lengths(kind: type[Signal]) -> bytes:
    """Return a message of two vehicles that says it has one name."""
    data = encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9)
    alone = encode(synthetic_signal(kind, 1.0, VEHICLES[:1]), 10**9)
    names, begin = data.index(b"cf1"), alone.index(b"cf1")
    return alone[: begin + 4] + data[names + 12 :]


def huge_array(kind: type[Signal]) -> bytes:
    """Return a message that says it has four thousand million names."""
    data = bytearray(encode(synthetic_signal(kind, 1.0, VEHICLES), 10**9))
    at = data.index(b"cf1") - 8
    data[at : at + 4] = b"\xff\xff\xff\xff"
    return bytes(data)


@pytest.mark.parametrize("name", NODES)
@pytest.mark.parametrize("wrong", [wrong_frame, name_twice, unequal_lengths, huge_array])
def test_each_named_wrong_is_refused_by_its_topic_and_leaves_a_node_as_it_was(
    name: str, wrong: Callable[[type[Signal]], bytes]
) -> None:
    (node, kept), (twin, _), tick = pair(name)
    for kind, receive in node.receivers():
        before = kept.health.refused
        receive(wrong(kind))
        assert kept.health.refused == before + 1
    tick[0] += TICK_NS
    answers = node.answer(tick[0]), twin.answer(tick[0])
    assert len(answers[0]) == len(answers[1]) == 1
    for one, other in zip(*answers, strict=True):
        _same(decode(one, _kind_of(one)), decode(other, _kind_of(other)))


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("q2q_model.interference", {"correct_vehicle": "crazyflie_2_0"}),
        ("q2q_control.pid", {"correct": True}),
        ("q2q_control.mpc", {"correct": True}),
    ],
)
@pytest.mark.parametrize("wrong", [lambda _: b"", wrong_size, name_twice])
def test_measurements_that_correct_the_downwash_are_refused_if_they_are_invalid(
    name: str, given: Mapping[str, ParameterValue], wrong: Callable[[type[Signal]], bytes]
) -> None:
    node, kept = built(name, given)
    receivers = node.receivers()
    assert SwarmImu in {kind for kind, _ in receivers}
    for kind, receive in receivers:
        before = kept.health.refused
        receive(wrong(kind))
        assert kept.health.refused == before + 1


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    output=st.one_of(
        st.text(max_size=50), st.sampled_from(['{"format": "q2q model"}', "[]", "null", "1e999"])
    )
)
def test_a_model_that_is_none_is_left_and_the_last_one_flies_on(output: str) -> None:
    (node, _), (twin, _), tick = pair("q2q_model.interference")
    (take_up,) = [receive for message, receive in node.readers if message is String]
    take_up(String(data=output))
    tick[0] += TICK_NS
    for one, other in zip(node.answer(tick[0]), twin.answer(tick[0]), strict=True):
        _same(decode(one, _kind_of(one)), decode(other, _kind_of(other)))


@pytest.mark.parametrize("name", NODES)
@settings(max_examples=15, deadline=None, derandomize=True)
@given(data=st.data())
def test_absurd_ticks_raise_nothing_and_are_forgotten_by_the_next_good_ones(
    name: str, data: st.DataObject
) -> None:
    node, tick = absurd_node(name)
    tick[0] += TICK_NS
    with np.errstate(all="ignore"):
        for kind, receive in node.receivers():
            receive(encode(data.draw(absurd(kind)), tick[0]))
        # a second of good ticks: longer than any coasting, holding or fading that a fault may have begun
        for _ in range(100):
            tick[0] += TICK_NS
            answer = node.answer(tick[0])
    (last,) = answer
    signal = decode(last, _kind_of(last))
    assert set(VEHICLES) <= set(signal.names)
    if isinstance(signal, SwarmCommand):
        assert np.isfinite([signal.thrust, signal.roll, signal.pitch, signal.yaw_rate]).all()


@cache
def absurd_node(name: str) -> tuple[Listening, list[int]]:
    """Return a node, and the last tick it was fed."""
    return built(name)[0], [0]


def _kind_of(data: bytes) -> type[Signal]:
    for kind in LAYOUTS:
        try:
            decode(data, kind)
        except ValueError:
            continue
        return kind
    raise AssertionError("a node published what nobody can read")


def _same(one: Signal, other: Signal) -> None:
    for entry in fields(one):
        np.testing.assert_array_equal(getattr(one, entry.name), getattr(other, entry.name))
