"""What `~/stop` of the node `radio` answers: the same as `~/emergency`."""

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_vehicles import by_radio

from q2q_model.node.reply import Reply

NAMES = ("emergency", "stop")
STOPPED = Reply(granted=True, reason="motors stopped; restart the vehicles")


@pytest.mark.parametrize("name", NAMES)
def test_a_dry_run_answers_that_nothing_is_sent(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    flown = by_radio(monkeypatch, dry_run=True)
    reply = flown.room.call(name)
    assert reply.reason.startswith("dry run, not executed; ")
    assert not any(link.health().locked for link in flown.links.values())


@pytest.mark.parametrize("name", NAMES)
def test_vehicles_are_locked_when_a_stop_is_answered(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    flown = by_radio(monkeypatch)
    flown.room.wait(0.1)
    assert flown.room.call(name) == STOPPED
    assert all(link.health().locked for link in flown.links.values())


@pytest.mark.parametrize("name", NAMES)
def test_a_stop_names_a_vehicle_that_is_not_connected(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    flown = by_radio(monkeypatch)
    flown.links["cf1"].reported["connected"] = False
    flown.room.wait(0.1)
    assert flown.room.call(name) == Reply(
        granted=False,
        reason="cf1 not reached: motors will be stopped when radio reconnects; "
        "motors of cf2 stopped; restart the vehicles",
    )
