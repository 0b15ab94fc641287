"""What `~/stop` of the node `radio` answers: the same as `~/emergency`."""

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_vehicles import by_radio

NAMES = ("emergency", "stop")


@pytest.mark.parametrize("name", NAMES)
def test_a_dry_run_answers_that_nothing_is_sent(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    flown = by_radio(monkeypatch, dry_run=True)
    reply = flown.room.call(name)
    assert reply.reason.startswith("dry run, nothing is sent; ")
    assert not any(link.health().locked for link in flown.links.values())
