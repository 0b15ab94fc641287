"""What `~/stop` of the node `radio` answers: the same as `~/emergency`; and what a stop does in a dry run."""

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_vehicles import Flown, by_radio
from std_srvs.srv import Empty

from q2q_control.flight_procedure.steps import Call
from q2q_model.node.reply import Reply

NAMES = ("emergency", "stop")
STOPPED = Reply(granted=True, reason="motors stopped; restart the vehicles")


def flown_by_another_client(monkeypatch: pytest.MonkeyPatch, **given: object) -> Flown:
    """Return vehicles that another client has let hover at 0.5 m, and that a dry run is connected to."""
    flown = by_radio(monkeypatch, dry_run=True, **given)
    flown.room.wait(0.1)
    for link in flown.links.values():
        link.arm()
    flown.room.wait(1.5)
    for link in flown.links.values():
        link.take_off(0.5, 1.0)
    flown.room.wait(1.5)
    assert flown.room.height[-1].min() > 0.4
    return flown


@pytest.mark.parametrize("name", NAMES)
def test_a_dry_run_stops_the_motors_of_vehicles_that_another_client_flies(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    flown = flown_by_another_client(monkeypatch)
    assert flown.room.call(name) == STOPPED
    assert all(link.health().locked for link in flown.links.values())
    assert flown.room.call(Call.TAKE_OFF).reason.startswith("dry run, not executed; the step is stopped")
    flown.room.wait(1.0)
    assert flown.room.height[-1].max() < 0.02


@pytest.mark.parametrize("mode", ["command", "setpoint"])
def test_a_dry_run_stops_the_motors_when_all_emergency_is_called(
    monkeypatch: pytest.MonkeyPatch, mode: str
) -> None:
    flown = flown_by_another_client(monkeypatch, mode=mode)
    flown.room.node.services["all/emergency"].ask(Empty.Request(), Empty.Response())
    flown.room.wait(0.1)
    assert all(link.health().locked for link in flown.links.values())


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
