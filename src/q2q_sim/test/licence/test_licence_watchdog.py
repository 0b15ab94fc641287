"""The watchdog of the emergency stop is the reason of what it does."""

from pathlib import Path

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from flown_programs import flown, log_of, written

from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.trial_processes import FlownTrial

FED = """
import time
import cflib.crtp
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
with SyncCrazyflie("radio://0/80/2M/E7E7E7E7E7") as scf:
    commander, watchdog = scf.cf.high_level_commander, scf.cf.supervisor.send_emergency_stop_watchdog
    {flight}
    commander.land(0.0, 1.0)
    time.sleep(1.5)
    commander.stop()
"""


def fed(folder: Path, flight: str) -> FlownTrial:
    """Return the flight of a program that does what is given, and lands."""
    return flown(written(folder, FED.format(flight=flight)))


def test_motors_that_a_watchdog_stops_are_blamed_on_its_last_feeding(tmp_path: Path) -> None:
    """Also of a vehicle that another command came to since, and that has a stop command while it falls."""
    flight = "commander.takeoff(0.8, 1.0); time.sleep(1.0); watchdog(); time.sleep(0.9); watchdog()"
    flight = fed(tmp_path, f"{flight}; commander.go_to(0, 0, 0.8, 0, 2); time.sleep(1.2); commander.stop()")
    last = [one.t for one in log_of(flight).commands if one.asked.kind == CommandKind.WATCHDOG][-1]
    why = f"no other came for 1 s after feeding of the emergency stop watchdog at {last:.2f} s, line 9"
    assert [(one.rule, one.why) for one in flight.findings] == [("motors", why), ("landing", why)]
    assert flight.findings[0].t == pytest.approx(last + 1.0, abs=0.05)  # the supervisor looks every 0.04 s


def test_a_vehicle_that_a_watchdog_locks_just_above_the_floor_fails(tmp_path: Path) -> None:
    flight = fed(tmp_path, "watchdog(); commander.takeoff(1.0, 2.0); time.sleep(2.5)")
    (found,) = flight.findings
    assert found.rule == "locked"
    assert found.what.startswith("the supervisor locks cf1 at a height of 0.")
    assert found.why.startswith("no other came for 1 s after feeding of the emergency stop watchdog at ")


def test_a_vehicle_that_a_watchdog_has_locked_on_the_floor_is_not_armed_for_that_reason(
    tmp_path: Path,
) -> None:
    flight = fed(tmp_path, "watchdog(); time.sleep(1.5); commander.takeoff(0.8, 1.0)")
    (idle,) = flight.findings
    assert (idle.rule, idle.why.partition(", ")[0]) == (
        "idle",
        "the emergency stop watchdog was not fed for 1 s",
    )


def test_a_watchdog_that_is_fed_to_the_end_is_no_cause_of_a_fall(tmp_path: Path) -> None:
    cut = "commander.takeoff(0.8, 1.0); time.sleep(1.0); watchdog(); time.sleep(0.5); commander.stop()"
    flight = fed(tmp_path, f"{cut}; time.sleep(2.0)")
    found = [(one.rule, one.why.partition(" at ")[0]) for one in flight.findings]
    assert found == [("motors", "high-level stop"), ("landing", "high-level stop")]
