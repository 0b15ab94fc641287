"""Programs that wait for ever, fail or die are reported with the line where they do."""

from pathlib import Path

import pytest
from flown_programs import ONE, flown, hop, written

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.licence.program_process.simulator_errors import is_of_room
from q2q_sim.licence.room.licence_room import LicenceRoom
from q2q_sim.licence.room.trials import LicenceTrial
from q2q_sim.loop.room import Room


def test_a_deadlock_and_a_wait_outside_the_clock_are_reported_with_their_lines(tmp_path: Path) -> None:
    deadlock = hop(
        tmp_path, "import threading\n    lock = threading.Lock(); lock.acquire()\n    lock.acquire()"
    )
    flight = flown(deadlock, limit=4.0)
    assert flight.findings[0].why == "it waits on line 14"
    outside = hop(tmp_path, "import select\n    select.select([], [], [], 60.0)")
    flight = flown(outside, timeout=3.0)
    assert flight.findings[0].why.endswith("for input, a socket or a process on line 13")


def test_an_error_of_a_callback_that_cflib_catches_is_reported_where_the_program_waits_for_it(
    tmp_path: Path,
) -> None:
    wait = """
    import threading
    from cflib.crazyflie.log import LogConfig
    seen, power = threading.Event(), LogConfig("power", 100)
    def came(_, values, __):
        print(values["pm.vbatt"])
        seen.set()
    power.add_variable("pm.vbat", "float")
    scf.cf.log.add_config(power); power.data_received_cb.add_callback(came); power.start()
    seen.wait()"""
    flight = flown(hop(tmp_path, wait), limit=6.0)
    why = (
        "it waits on line 21; an earlier callback failed, and cflib caught it: KeyError: 'pm.vbatt', line 17"
    )
    assert flight.findings[0].why == why


@pytest.mark.parametrize(("seconds", "error"), [
    ("-0.1", "ValueError: sleep length must be non-negative"),
    ("float('nan')", "ValueError: Invalid value NaN (not a number)"),
])  # fmt: skip
def test_a_sleep_that_python_refuses_is_refused(tmp_path: Path, seconds: str, error: str) -> None:
    flight = flown(written(tmp_path, f"import time\ntime.sleep(0)\ntime.sleep({seconds})\n"), limit=9.0)
    assert [one.why for one in flight.findings] == [f"{error}, line 3"]


def test_a_process_that_dies_is_reported_with_its_signal_or_status(tmp_path: Path) -> None:
    kill = hop(tmp_path, "import os, signal; os.kill(os.getpid(), signal.SIGKILL)")
    flight = flown(kill)
    assert [one.sentence for one in flight.findings] == ["the program's process dies: signal 9, Killed"]


@pytest.mark.parametrize(("kind", "own"), [(LookupError, True), (RecursionError, False)])
def test_a_stack_that_ends_in_the_room_is_no_error_of_the_room(
    kind: type[Exception], own: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise kind

    room = LicenceRoom(ONE, LicenceTrial())
    monkeypatch.setattr(Room, "fly", fail)
    with pytest.raises(kind) as caught:
        room.fly()
    assert is_of_room(caught.value) is own
