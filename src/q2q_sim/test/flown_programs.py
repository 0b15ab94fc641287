"""Programs of a licence that are flown once, and one that hops."""

from dataclasses import replace
from math import inf
from pathlib import Path

from q2q_sim.licence.flight_order import FlightOrder, Program
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import LicenceTrial
from q2q_sim.licence.trial_processes import FlownTrial, fly_trials

ONE = LicenceParams(((0.0, 0.0, 0.0),))
"""Room with one vehicle in its middle."""
HOP = """
import time
import cflib.crtp
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
with SyncCrazyflie("radio://0/80/2M/E7E7E7E7E7") as scf:
    commander = scf.cf.high_level_commander
    time.sleep(0.5)
    commander.takeoff(0.4, 1.0)
    time.sleep(1.5)
    {end}
"""
LAND = "commander.land(0.0, 1.0); time.sleep(1.5); commander.stop()"


def written(folder: Path, text: str) -> Program:
    """Return a program of that text."""
    file = folder / "flight.py"
    file.write_text(text)
    return Program(file, (), folder)


def hop(folder: Path, end: str) -> Program:
    """Return a program that takes off and then does what is given; its first line is line 13."""
    file = folder / "hop.py"
    file.write_text(HOP.format(end=end))
    return Program(file, (), folder)


def order_of(program: Program, **more: object) -> FlightOrder:
    """Return the order of a flight of one vehicle, 30 s at most."""
    return replace(FlightOrder(program, ONE, LicenceTrial(), (), (), 30.0), **more)  # type: ignore[arg-type]


def flown(program: Program, **more: object) -> FlownTrial:
    """Return the flight of a program, by itself."""
    (flight,) = fly_trials([order_of(program, **more)], LicenceOptions(), until=inf)
    return flight


def log_of(flight: FlownTrial) -> LicenceLog:
    """Return the log of a flight that the simulator flew to its end."""
    assert flight.log is not None
    return flight.log
