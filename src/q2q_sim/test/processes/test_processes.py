"""Processes of a flight: the death of a node is an error with its status and its last words."""

from multiprocessing import get_context
from pathlib import Path

import pytest

from q2q_sim.processes import processes
from q2q_sim.processes.processes import NodeDiedError, NodeSpec, Processes


def test_a_node_that_dies_before_it_writes_a_word_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dying(_: object) -> object:
        process = get_context("spawn").Process(target=exit, args=(3,))
        process.start()
        process.join()
        return process

    monkeypatch.setattr(processes, "start_forked", dying)
    started = Processes(tmp_path)
    started.start(NodeSpec("q2q_model", "mocap_filter", {}))
    with pytest.raises(NodeDiedError, match="mocap_filter ended with status 3: no output"):
        started.check()


@pytest.mark.parametrize("error", [EOFError("unexpected EOF"), ConnectionRefusedError(111, "refused")])
def test_a_node_whose_fork_server_is_killed_meanwhile_has_not_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    """SIGTERM to all processes of a flight, as `timeout` sends it, ended in a traceback."""

    def killed(_: object) -> None:
        raise error

    monkeypatch.setattr(processes, "start_forked", killed)
    message = "^mocap_filter did not start: the process that starts nodes was killed$"
    with pytest.raises(NodeDiedError, match=message):
        Processes(tmp_path).start(NodeSpec("q2q_model", "mocap_filter", {}))
