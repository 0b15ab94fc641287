"""`call --on-enter` calls its service when Enter is pressed; no call waits for a node that is gone."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf
from threading import Event, Thread

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_control.commands import call
from q2q_control.ros.procedure_call import await_answer
from q2q_model.ros.node.bounded_spin import WAKE_S, make_executor
from q2q_sim.processes.domain import own_domain

TIMEOUT_S = 120.0
"""A process and its discovery on a busy machine [s]."""
READY = "radio/emergency is ready: press Enter to call it, Ctrl-C to leave"


@dataclass
class Pilot:
    """Service that counts its calls."""

    called: list[str] = field(default_factory=list)
    asked: Event = field(default_factory=Event)
    may_answer: Event = field(default_factory=Event)

    def __post_init__(self) -> None:
        """Answer at once."""
        self.may_answer.set()

    def answer(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Grant the call."""
        self.called.append("emergency")
        self.asked.set()
        self.may_answer.wait(TIMEOUT_S)
        response.success, response.message = True, "motors stopped"
        return response


@pytest.fixture
def pilot() -> Iterator[Pilot]:
    with own_domain():
        rclpy.init(args=[])
        node, executor, made = Node("radio"), make_executor(), Pilot()
        node.create_service(Trigger, "radio/emergency", made.answer)
        executor.add_node(node)
        over = Event()
        thread = Thread(target=_spin, args=(executor, over))
        thread.start()
        try:
            yield made
        finally:
            over.set()
            thread.join(TIMEOUT_S)
            rclpy.try_shutdown()


def _spin(executor: Executor, over: Event) -> None:
    while not over.is_set():
        never: Future[None] = Future()
        executor.spin_until_future_complete(never, WAKE_S)


def waiting_call() -> subprocess.Popen[str]:
    """Return the command once it is ready to call."""
    process = subprocess.Popen(
        [sys.executable, "-m", "q2q_control.commands.call", "emergency", "--on-enter"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline().strip() == READY
    return process


def test_it_calls_when_enter_is_pressed_and_not_before(pilot: Pilot) -> None:
    process = waiting_call()
    assert pilot.called == []
    output, _ = process.communicate("\n", timeout=TIMEOUT_S)
    assert (output.strip(), process.returncode) == ("radio/emergency: motors stopped", 0)
    assert pilot.called == ["emergency"]


def test_the_end_of_the_input_calls_nothing(pilot: Pilot) -> None:
    _, error = (process := waiting_call()).communicate("", timeout=TIMEOUT_S)
    assert (error.strip(), process.returncode) == ("radio/emergency: not sent", 1)
    assert pilot.called == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_call_in_one_line_that_says_that_it_goes_on(pilot: Pilot, number: int) -> None:
    pilot.may_answer.clear()
    process = waiting_call()
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()
    assert pilot.asked.wait(TIMEOUT_S)
    process.send_signal(number)
    _, error = process.communicate(timeout=TIMEOUT_S)
    pilot.may_answer.set()
    assert (error.strip(), process.returncode) == ("call: interrupted; the call continues", 130)


class Silent:
    """Client of a service, and executor, of a node that answers nothing."""

    def __init__(self, *, ready: bool) -> None:
        self._ready = ready

    def call_async(self, _: Trigger.Request) -> "Future[Trigger.Response]":
        """Return an answer that never comes."""
        return Future()

    def service_is_ready(self) -> bool:
        """Return whether the node is there."""
        return self._ready

    def spin_until_future_complete(self, _: "Future[Trigger.Response]", __: float) -> None:
        """Wait for nothing."""


def test_a_node_that_leaves_without_an_answer_ends_the_call() -> None:
    reply = await_answer(Silent(ready=False), Silent(ready=False), inf)
    assert (reply.granted, "left without an answer" in reply.reason) == (False, True)


def test_a_call_that_must_not_wait_ends_though_the_node_is_there() -> None:
    reply = await_answer(Silent(ready=True), Silent(ready=True), 0.0)
    assert (reply.granted, "no answer within 0 s" in reply.reason) == (False, True)


@pytest.mark.parametrize("given", ["bad name", "", "/", "room//radio", "1radio", "r\u00e9seau"])
def test_what_is_no_nodes_name_is_refused_with_one_that_is(
    given: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        call.parser().parse_args(["land", "--node", given])
    assert ended.value.code == 2
    assert f"{given!r} is not a node name: give one like radio or room/radio" in capsys.readouterr().err


@pytest.mark.parametrize(("given", "node"), [("/radio/", "radio"), ("/room/radio", "room/radio")])
def test_slashes_around_a_nodes_name_are_no_part_of_it(given: str, node: str) -> None:
    assert call.parser().parse_args(["land", "--node", given]).node == node
