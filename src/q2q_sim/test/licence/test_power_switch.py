"""PowerSwitch of cflib reboots the vehicles of a licence and turns them off."""

from pathlib import Path

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from flown_programs import LAND, flown, hop, log_of

POWER = "from cflib.utils.power_switch import PowerSwitch; switch = PowerSwitch('radio://0/80/2M/E7E7E7E7E7')"


def test_a_vehicle_that_was_locked_is_rebooted_and_flies(tmp_path: Path) -> None:
    again = f"""commander.land(0.0, 1.0); time.sleep(1.5)
    scf.cf.loc.send_emergency_stop(); time.sleep(0.5); scf.close_link()
    {POWER}; switch.stm_power_cycle(); switch.close(); time.sleep(1.0); scf.open_link()
    commander.takeoff(0.5, 1.0); time.sleep(1.5)
    {LAND}"""
    flight = flown(hop(tmp_path, again))
    assert flight.findings == ()
    log = log_of(flight)
    reboot = next(one.t for one in log.commands if one.asked.words.startswith("power-up"))
    assert log.pos[log.t < reboot, 0, 2].max() == pytest.approx(0.4, abs=0.1)  # it has not settled
    assert log.pos[log.t > reboot, 0, 2].max() == pytest.approx(0.5, abs=0.1)


def test_a_vehicle_that_is_turned_off_in_the_air_falls_for_that_reason(tmp_path: Path) -> None:
    flight = flown(hop(tmp_path, f"{POWER}\n    switch.stm_power_down(); time.sleep(1.0)"))
    motors = flight.findings[0]
    assert motors.rule == "motors"
    assert motors.why.startswith("power-down at ")
    assert motors.why.endswith(", line 13")
