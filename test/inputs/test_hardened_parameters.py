"""Any value may be asked for any parameter: it is taken or refused with a reason, and the node flies on."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter as Given

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_control.ros.controller_wiring import ControllerNodeParams
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.node_parameters import declare, on_change
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time, stamp_parts
from q2q_model.signals.values import SwarmCommand
from q2q_model.trajectory import plan_file
from q2q_model.vehicle.constants import TEXTBOOK_065
from q2q_planner.ros.trajectory_node import TrajectoryParams
from q2q_sim.loop import flight_blocks
from q2q_sim.processes.domain import own_domain
from q2q_sim.scenarios import library

VEHICLES = ("cf1", "cf2")
NODES = (
    "q2q_model.mocap_filter",
    "q2q_model.interference",
    "q2q_planner.trajectory",
    "q2q_planner.replanner",
    "q2q_control.pid",
    "q2q_control.mpc",
)
KINDS = {message: kind for kind, message in MESSAGES.items()}
TICK_NS = 10_000_000
MADE: list[Node] = []
"""Nodes to destroy: one that is left listens in its domain as long as this process lives."""
whole = st.one_of(st.integers(-5, 50), st.sampled_from([-(2**63), 2**63 - 1]))
real = st.one_of(
    st.floats(-2.0, 100.0), st.floats(), st.sampled_from([np.nan, np.inf, -np.inf, 1e300, 0.0, -0.0])
)
text = st.one_of(st.sampled_from(["", "none", "paper", "safe", "cf1"]), st.text(max_size=6)).filter(
    lambda output: "\x00" not in output  # a C string ends there
)


def values() -> st.SearchStrategy[ParameterValue]:
    """Return values of every type that a parameter can have, and of none."""
    kinds = ParameterType
    scalars = [
        st.builds(ParameterValue, type=st.just(kinds.PARAMETER_BOOL), bool_value=st.booleans()),
        st.builds(ParameterValue, type=st.just(kinds.PARAMETER_INTEGER), integer_value=whole),
        st.builds(ParameterValue, type=st.just(kinds.PARAMETER_DOUBLE), double_value=real),
        st.builds(ParameterValue, type=st.just(kinds.PARAMETER_STRING), string_value=text),
    ]
    arrays = [
        st.builds(
            ParameterValue,
            type=st.just(kinds.PARAMETER_BYTE_ARRAY),
            byte_array_value=st.lists(st.binary(min_size=1, max_size=1), max_size=3),
        ),
        st.builds(
            ParameterValue,
            type=st.just(kinds.PARAMETER_BOOL_ARRAY),
            bool_array_value=st.lists(st.booleans(), max_size=3),
        ),
        st.builds(
            ParameterValue,
            type=st.just(kinds.PARAMETER_INTEGER_ARRAY),
            integer_array_value=st.lists(whole, max_size=3),
        ),
        st.builds(
            ParameterValue,
            type=st.just(kinds.PARAMETER_DOUBLE_ARRAY),
            double_array_value=st.lists(real, max_size=3),
        ),
        st.builds(
            ParameterValue,
            type=st.just(kinds.PARAMETER_STRING_ARRAY),
            string_array_value=st.lists(text, max_size=3),
        ),
    ]
    return st.one_of(st.just(ParameterValue()), *scalars, *arrays)


class Real:
    """Node that is never spun: tests call its callbacks."""

    def __init__(self, name: str, folder: Path) -> None:
        package, executable = name.split(".")
        given = [Given(f"{one}_hz", value=0.0) for one in ("vehicle_topics", "legacy")]
        if executable == "trajectory":
            plan_file.save(folder / "plan.json", flight_blocks.plan_of(library.load("table6")))
            given.append(Given("plan", value=str(folder / "plan.json")))
        self.node = Node(executable, parameter_overrides=given)
        MADE.append(self.node)
        self._made: list[Signal] = []
        wiring = import_module(f"{package}.ros.{executable}_node").build(self.node)
        wiring.after_publish(lambda _, made: self._made.append(made))
        self._tick = 0
        own = {"use_sim_time"}  # rclpy's
        self.names = sorted(set(self.node.get_parameters_by_prefix("")) - own)
        self.open = [name for name in self.names if not self.node.describe_parameter(name).read_only]
        """Which may change in flight."""

    def likely(self, name: str) -> st.SearchStrategy[ParameterValue]:
        """Return values of a parameter's own type, that it may well take."""
        value = self.node.get_parameter(name).get_parameter_value()
        if value.type == ParameterType.PARAMETER_DOUBLE:
            numbers = st.one_of(st.floats(0.0, 2.0), st.floats(0.0, 20.0))
            return st.builds(ParameterValue, type=st.just(value.type), double_value=numbers)
        if value.type == ParameterType.PARAMETER_INTEGER:
            return st.builds(ParameterValue, type=st.just(value.type), integer_value=st.integers(0, 30))
        return st.builds(ParameterValue, type=st.just(value.type), bool_value=st.booleans())

    def ask(self, name: str, value: ParameterValue) -> tuple[bool, str]:
        """Return what the node's own parameter service answers."""
        service = self.node._parameter_service  # what a client reaches
        request = SetParameters.Request(parameters=[Parameter(name=name, value=value)])
        (result,) = service._set_parameters_callback(request, SetParameters.Response()).results
        return bool(result.successful), str(result.reason)

    def answer(self) -> Signal:
        """Return what the node makes of a good tick."""
        self._tick += TICK_NS
        self._made.clear()
        for reader in self.node.subscriptions:
            if reader.msg_type in KINDS:
                kind = KINDS[reader.msg_type]
                reader.callback(encode(synthetic_signal(kind, self._tick * 1e-9, VEHICLES), self._tick))
        (made,) = self._made
        return made


@pytest.fixture(scope="module", autouse=True)
def ros() -> Iterator[None]:
    with own_domain():
        rclpy.init()
        yield
        while MADE:
            MADE.pop().destroy_node()
        real_node.cache_clear()
        rclpy.try_shutdown()


@cache
def real_node(name: str, folder: Path) -> Real:
    return Real(name, folder)


@pytest.mark.parametrize("name", NODES)
def test_what_a_node_does_not_heed_in_flight_is_refused(
    name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    node = real_node(name, tmp_path_factory.getbasetemp())
    fixed = [one for one in node.names if one not in node.open]
    assert fixed
    for one in fixed:
        before = node.node.get_parameter_or(one)
        taken, reason = node.ask(one, before.get_parameter_value())
        assert (taken, "read-only" in reason) == (False, True), one
        assert node.node.get_parameter_or(one).value == before.value


@pytest.mark.parametrize("name", NODES)
def test_all_parameters_are_reported_with_a_value_as_by_param_dump(
    name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    node = real_node(name, tmp_path_factory.getbasetemp())
    service = node.node._parameter_service
    response = service._get_parameters_callback(
        GetParameters.Request(names=node.names), GetParameters.Response()
    )
    kinds = {one: value.type for one, value in zip(node.names, response.values, strict=True)}
    assert {ParameterType.PARAMETER_NOT_SET} & set(kinds.values()) == set()
    if "vehicles" in kinds:
        assert kinds["vehicles"] == ParameterType.PARAMETER_STRING_ARRAY


def test_a_parameter_that_was_changed_in_flight_is_logged_with_both_values(
    capfd: pytest.CaptureFixture[str],
) -> None:
    node = Node("changing_block")
    MADE.append(node)
    params = declare(node, PidParams(k_p_z=6.0), "law.", in_flight=True)
    on_change(node, params, Pid(params, TEXTBOOK_065).configure, "law.")
    node.set_parameters([Given("law.k_p_z", value=value) for value in (7.0, -1.0, 7.0)])
    lines = [line.partition("]: ")[2] for line in capfd.readouterr().err.splitlines() if "k_p_z" in line]
    assert lines == ["law.k_p_z changed from 6.0 to 7.0"]


def test_parameters_of_others_neither_configure_a_block_nor_are_refused_by_it() -> None:
    node, taken = Node("two_blocks"), list[PidParams]()
    MADE.append(node)
    params = declare(node, PidParams(), in_flight=True)
    on_change(node, params, taken.append)
    declare(node, FallbackParams())
    (answer,) = node.set_parameters([Given("k_p_z", value=7.0)])
    assert answer.successful
    assert taken == [replace(params, k_p_z=7.0)]


def test_what_a_block_has_refused_does_not_stand_in_the_way_of_the_next_change() -> None:
    node = Node("refusing_block")
    MADE.append(node)
    params = declare(node, PidParams(), in_flight=True)
    on_change(node, params, Pid(params, TEXTBOOK_065).configure)
    low = [Given("thrust_max", value=0.1), Given("thrust_limited", value=True)]
    together = node.set_parameters_atomically(low)
    assert (together.successful, "thrust_max = 0.1 N" in together.reason) == (False, True)
    (answer,) = node.set_parameters([Given("k_p_z", value=7.0)])
    assert (answer.successful, answer.reason) == (True, "")


@pytest.mark.parametrize(
    ("name", "value", "example"),
    [
        ("k_p_z", 5, "5.0"),
        ("k_p_z", "high", f"{PidParams().k_p_z}"),
        ("vehicles", "cf1", "['cf1']"),
        ("vehicles", 1, "['1']"),
        ("vehicles", "", "[]"),
        ("vehicles", [1, 2], "['1', '2']"),
    ],
)
def test_a_value_of_the_wrong_type_is_refused_with_an_example(name: str, value: object, example: str) -> None:
    node = Node("wrong_type", parameter_overrides=[Given(name, value=value)])
    MADE.append(node)
    message = f"parameter {name} = {value!r} has the wrong type; give a value like {example}"
    with pytest.raises(ValueError, match=re.escape(message)):
        declare(node, PidParams() if name == "k_p_z" else ControllerNodeParams())


@pytest.mark.parametrize("start", [np.inf, np.nan, 2.0**31, 1e30])
def test_a_plan_that_starts_beyond_the_last_stamp_of_a_message_is_refused(start: float) -> None:
    with pytest.raises(ValueError, match=r"start = .*; must be at most 2147483647\.0 s"):
        TrajectoryParams(start=start)
    last = TrajectoryParams(start=2.0**31 - 1.0).start
    assert stamp_parts(stamp_from_time(last)) == (2**31 - 1, 0)


@pytest.mark.parametrize("name", NODES)
@settings(max_examples=60, deadline=None, derandomize=True)
@given(data=st.data())
def test_a_parameter_is_taken_or_refused_with_a_reason_and_the_next_tick_is_good(
    name: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    node = real_node(name, tmp_path_factory.getbasetemp())
    if node.open and data.draw(st.booleans()):
        asked = data.draw(st.sampled_from(node.open))
        value = data.draw(node.likely(asked))
    else:
        asked = data.draw(st.sampled_from([*node.names, "no_such_parameter"]))
        value = data.draw(values())
    taken, reason = node.ask(asked, value)
    assert taken or reason
    assert not (taken and asked == "no_such_parameter")
    with np.errstate(all="ignore"):  # a gain of 1e300 may be asked for where there is no bound
        made = node.answer()
    assert set(VEHICLES) <= set(made.names)
    if isinstance(made, SwarmCommand):
        assert np.isfinite([made.thrust, made.roll, made.pitch, made.yaw_rate]).all()
