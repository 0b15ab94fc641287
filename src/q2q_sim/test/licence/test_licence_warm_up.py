"""Kernels of a flight are compiled before it, or without being interrupted."""

from pathlib import Path

import pytest
from flown_programs import LAND, flown, hop, log_of, written

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind

SLOW_TICKS = """
import time
from q2q_sim.licence.room.licence_room import LicenceRoom
fly, within = LicenceRoom.fly, []

def slow(room):
    assert not within, "a tick within a tick"
    within.append(room)
    began = time.process_time()
    while time.process_time() - began < 1.0:
        pass
    within.clear()
    fly(room)

LicenceRoom.fly = slow
import cflib.crtp
from cflib.crazyflie import Crazyflie
cflib.crtp.init_drivers()
for number in (1, 2):
    Crazyflie().open_link(f"radio://0/80/2M/E7E7E7E7E{number}")
"""


def test_the_tick_after_a_program_is_not_interrupted_by_looks_at_it(tmp_path: Path) -> None:
    """The kernels of a first tick may be compiled in it, in seconds, and are not re-entrant meanwhile."""
    flight = flown(written(tmp_path, SLOW_TICKS), timeout=5.0)
    assert log_of(flight).end.unknown == "radio://0/80/2M/E7E7E7E7E2"


WARM_UP = """
from q2q_model.compiled import KERNELS
from q2q_sim.licence.room.licence_room import LicenceParams, LicenceRoom
from q2q_sim.licence.room.trials import LicenceTrial

def called():
    return {(one.name, kind) for one in KERNELS for kind in getattr(one.made, "overloads", ())}

LicenceRoom(LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial()).fly()
warm = called()
"""


def test_the_warm_up_tick_calls_every_kernel_of_a_flight(tmp_path: Path) -> None:
    """The program warms up in the process of its flight, and lists what its flight calls beyond that."""
    program = hop(tmp_path, f"{LAND}\n    print(called() - warm)")
    program.file.write_text(WARM_UP + program.file.read_text())
    params = LicenceParams(((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    uris = ("radio://0/80/2M/E7E7E7E7E7", "radio://0/80/2M/E7E7E7E7E8")
    trial = LicenceTrial(TrialKind.SWAP, start=0.1, other=1)
    flight = flown(program, params=params, trial=trial, uris=uris)
    assert log_of(flight).output.splitlines()[-1] == "set()"
