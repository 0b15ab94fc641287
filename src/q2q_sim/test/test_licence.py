"""Programs fly unmodified: one sound, one with a bug; the clock of their threads is that of the room."""

import threading
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.air.air_names import AirError
from q2q_sim.experiments.licence.client_commands.client_command import CommandKind
from q2q_sim.experiments.licence.flight_order import FlightOrder, Program
from q2q_sim.experiments.licence.licence_flights import Licence, LicenceOptions, fly_trials, licence
from q2q_sim.experiments.licence.licence_reports import (
    junit_xml,
    licence_json,
    report_text,
    verdict_text,
    write_licence_page,
)
from q2q_sim.experiments.licence.program.cooperative_scheduler import CooperativeScheduler, always
from q2q_sim.experiments.licence.program.simulator_errors import is_of_room
from q2q_sim.experiments.licence.room.licence_room import LicenceParams, LicenceRoom
from q2q_sim.experiments.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.experiments.licence.rules.licence_limits import LicenceLimits
from q2q_sim.loop.room import Room

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


def hop(folder: Path, end: str) -> Program:
    file = folder / "hop.py"
    file.write_text(HOP.format(end=end))
    return Program(file, (), folder)


def start(scheduler: CooperativeScheduler, run: Callable[[], None]) -> threading.Thread:
    gate = scheduler.enter()

    def body() -> None:
        scheduler.take(gate)
        run()
        scheduler.leave()

    thread = threading.Thread(target=body, daemon=True)
    thread.start()
    return thread


def test_threads_wake_in_the_order_of_their_deadlines_and_ticks_pass_between():
    seen: list[tuple[str, float]] = []
    scheduler = CooperativeScheduler(lambda: seen.append(("tick", scheduler.now)), 1.0)

    def sleeper(name: str, seconds: float) -> Callable[[], None]:
        def run() -> None:
            scheduler.sleep(seconds)
            seen.append((name, scheduler.now))

        return run

    threads = [start(scheduler, sleeper("late", 1.5)), start(scheduler, sleeper("early", 0.5))]
    scheduler.sleep(2.5)
    for thread in threads:
        thread.join()
    assert seen == [("early", 0.5), ("tick", 1.0), ("late", 1.5), ("tick", 2.0)]


def test_a_condition_ends_a_wait_before_its_deadline_and_computing_takes_no_time():
    scheduler = CooperativeScheduler(lambda: None, 1.0)
    done: list[float] = []
    thread = start(scheduler, lambda: done.append(scheduler.now))
    assert scheduler.wait(lambda: bool(done), 5.0)
    thread.join()
    assert (scheduler.now, done) == (0.0, [0.0])
    assert not scheduler.wait(lambda: False, 0.25)
    assert scheduler.now == 0.25


def test_reading_a_clock_lets_time_pass_and_others_go_on():
    ticks: list[float] = []
    scheduler = CooperativeScheduler(lambda: ticks.append(scheduler.now), 0.01)
    while scheduler.now < 0.05:
        scheduler.spend(0.003)
    assert ticks == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    assert scheduler.wait(always, 1.0)


def test_a_sound_program_lands_and_flies_the_same_again(tmp_path: Path):
    program = hop(tmp_path, LAND)
    order = FlightOrder(program, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    one, other = fly_trials([order, order], LicenceOptions(), until=float("inf"))
    assert one.log is not None
    assert other.log is not None
    assert one.findings == ()
    assert one.log.end.t == pytest.approx(other.log.end.t, abs=1e-9)
    assert (one.log.pos == other.log.pos).all()
    assert 0.3 < one.log.pos[:, 0, 2].max() < 0.5  # asked for 0.4; it has not settled after 1.5 s
    assert one.log.pos[-1, 0, 2] <= 0.0


def test_a_program_that_ends_in_the_air_fails_with_time_and_reason(tmp_path: Path):
    found = licence(hop(tmp_path, "pass"), LicenceOptions())
    assert not found.passed
    (flight,) = found.flights
    first = flight.findings[0]
    assert first.rule == "motors"
    assert first.what.startswith("the motors of cf1 stop at a height of 0.3")
    assert first.why.startswith("the closing of the link")
    assert first.sentence in report_text(found)
    case = ET.fromstring(junit_xml(found).encode()).find("testsuite/testcase")  # noqa: S314  our own
    assert case is not None
    failure = case.find("failure")
    assert (case.get("classname"), case.get("name")) == ("hop", "nominal")
    assert failure is not None
    assert failure.get("message") == first.sentence
    assert licence_json(found)["passed"] is False
    page = write_licence_page(found, tmp_path / "page").read_text(encoding="utf-8")
    assert "without faults. It failed, so it did not fly with faults." in page


def test_a_pass_says_if_no_vehicle_flew(tmp_path: Path):
    program = hop(tmp_path, LAND)
    order = FlightOrder(program, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    (one,) = fly_trials([order], LicenceOptions(), until=inf)
    assert one.log is not None
    found = Licence(program, (one,), (), 1.0)
    assert verdict_text(found) == "PASS hop.py: 1 flight in 1 s"
    grounded = replace(one, log=replace(one.log, pos=np.zeros_like(one.log.pos)))
    found = replace(found, flights=(grounded,))
    assert (found.passed, licence_json(found)["flew"]) == (True, False)
    assert verdict_text(found) == "PASS hop.py: 1 flight in 1 s; no vehicle flew"
    page = write_licence_page(found, tmp_path / "page").read_text(encoding="utf-8")
    assert "with emulated vehicles, of which none left the floor." in page


def test_a_vehicle_that_does_not_arm_stays_on_the_floor(tmp_path: Path):
    trial = LicenceTrial(TrialKind.UNARMED)
    params = LicenceParams(((0.0, 0.0, 0.0),))
    order = FlightOrder(hop(tmp_path, LAND), params, trial, ("radio://0/80/2M/E7E7E7E7E7",), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=float("inf"))
    assert flight.log is not None
    assert not flight.log.flew.any()
    assert flight.findings == ()
    assert {one.asked.refused for one in flight.log.commands if one.asked.words.startswith("takeoff")} == {
        "the vehicle is not armed"
    }


def test_vehicles_are_armed_when_the_program_begins_and_take_less_thrust_than_their_weight_for_a_test(
    tmp_path: Path,
):
    """As in cflib's `ramp`, whose first setpoints come with the connection."""
    ramp = tmp_path / "ramp.py"
    params, head = LicenceParams(((0.0, 0.0, 0.0),)), HOP.partition("    commander =")[0]
    for most, lifts in ((25000, False), (40000, False), (48000, True)):  # 44 027 carry 34 g
        for_each = f"    for each in (0, {most}, 0):\n"
        ramp.write_text(
            f"{head}{for_each}        scf.cf.commander.send_setpoint(0, 0, 0, each); time.sleep(0.1)\n"
        )
        order = FlightOrder(Program(ramp, (), tmp_path), params, LicenceTrial(), (), (), 9.0)
        (flight,) = fly_trials([order], LicenceOptions(), until=inf)
        assert flight.log is not None
        (asked,) = (one.asked for one in flight.log.commands if one.asked.kind == CommandKind.SETPOINT)
        assert (asked.refused, asked.lifts) == ("", lifts)


def test_vehicles_without_starts_stand_in_as_few_rows_as_the_room_has_space_for():
    options = LicenceOptions(limits=LicenceLimits(half_room=(3.0, 3.0)))
    assert options.rows_of(3) == ((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    places = np.array(options.rows_of(15))[:, :2]
    assert (np.abs(places) <= 1.5).all()
    assert len(np.unique(places, axis=0)) == 15
    np.testing.assert_allclose(np.unique(places[:, 0]), [-1.5, -0.5, 0.5, 1.5])


def test_a_deadlock_and_a_wait_outside_the_clock_are_reported_with_their_lines(tmp_path: Path):
    params = LicenceParams(((0.0, 0.0, 0.0),))
    deadlock = hop(
        tmp_path, "import threading\n    lock = threading.Lock(); lock.acquire()\n    lock.acquire()"
    )
    order = FlightOrder(deadlock, params, LicenceTrial(), (), (), 4.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=float("inf"))
    assert flight.findings[0].why == "it waits on line 14"
    outside = hop(tmp_path, "import select\n    select.select([], [], [], 60.0)")
    order = FlightOrder(outside, params, LicenceTrial(), (), (), 30.0, timeout=3.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=float("inf"))
    assert flight.findings[0].why.endswith("for input, a socket or a process on line 13")


def test_an_error_of_a_callback_that_cflib_catches_is_reported_where_the_program_waits_for_it(tmp_path: Path):
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
    order = FlightOrder(hop(tmp_path, wait), LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 6.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    why = "it waits on line 21; a callback failed before, which cflib catches: KeyError: 'pm.vbatt', line 17"
    assert flight.findings[0].why == why


@pytest.mark.parametrize(("seconds", "error"), [
    ("-0.1", "ValueError: sleep length must be non-negative"),
    ("float('nan')", "ValueError: Invalid value NaN (not a number)"),
])  # fmt: skip
def test_a_sleep_that_python_refuses_is_refused(tmp_path: Path, seconds: str, error: str):
    file = tmp_path / "sleep.py"
    file.write_text(f"import time\ntime.sleep(0)\ntime.sleep({seconds})\n")
    order = FlightOrder(Program(file), LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 9.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert [one.why for one in flight.findings] == [f"{error}, line 3"]


def test_a_landing_in_an_exit_handler_is_flown(tmp_path: Path):
    land = f"import atexit\n    @atexit.register\n    def land(): {LAND}; scf.close_link()"
    program = hop(tmp_path, land)
    text = program.file.read_text().replace("with SyncCrazyflie", "scf = SyncCrazyflie")
    program.file.write_text(text.replace(" as scf:", "\nscf.open_link()\nif True:"))
    order = FlightOrder(program, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert flight.findings == ()


def test_dates_and_asyncio_go_by_the_clock_of_the_room(tmp_path: Path):
    """30 s of waiting, 20 of them in two tasks at a time, take no longer than the flight of as much."""
    wait = f"""
    import asyncio, datetime as dt, threading
    from datetime import datetime as now_of
    began, first = time.time(), now_of.now()
    async def rest():
        event, loop = asyncio.Event(), asyncio.get_running_loop()
        threading.Timer(10.0, lambda: loop.call_soon_threadsafe(event.set)).start()
        await asyncio.gather(asyncio.sleep(20.0), event.wait())
        print(round(time.time() - began, 2))
    asyncio.run(rest())
    while now_of.now() - first < dt.timedelta(seconds=30.0):
        time.sleep(0.1)
    print(round(time.time() - began, 1), dt.datetime.utcnow().year, isinstance(first, dt.datetime))
    {LAND}"""
    order = FlightOrder(hop(tmp_path, wait), LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 60.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert flight.log is not None
    assert flight.findings == ()
    assert flight.log.output.splitlines()[-2:] == ["20.0", "30.0 2026 True"]


def test_a_process_that_dies_is_reported_with_its_signal_or_status(tmp_path: Path):
    kill = hop(tmp_path, "import os, signal; os.kill(os.getpid(), signal.SIGKILL)")
    order = FlightOrder(kill, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=float("inf"))
    assert [one.sentence for one in flight.findings] == ["the program's process dies: signal 9, Killed"]


SLOW_TICKS = """
import time
from q2q_sim.experiments.licence.room.licence_room import LicenceRoom
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


def test_the_tick_after_a_program_is_not_interrupted_by_looks_at_it(tmp_path: Path):
    """The kernels of a first tick may be compiled in it, in seconds, and are not re-entrant meanwhile."""
    file = tmp_path / "slow.py"
    file.write_text(SLOW_TICKS)
    params = LicenceParams(((0.0, 0.0, 0.0),))
    order = FlightOrder(Program(file), params, LicenceTrial(), (), (), 30.0, timeout=5.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert flight.log is not None
    assert flight.log.end.unknown == "radio://0/80/2M/E7E7E7E7E2"


@pytest.mark.parametrize(("kind", "own"), [(LookupError, True), (RecursionError, False)])
def test_a_stack_that_ends_in_the_room_is_no_error_of_the_room(
    kind: type[Exception], own: bool, monkeypatch: pytest.MonkeyPatch
):
    def fail(*_: object) -> None:
        raise kind

    room = LicenceRoom(LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial())
    monkeypatch.setattr(Room, "fly", fail)
    with pytest.raises(kind) as caught:
        room.fly()
    assert is_of_room(caught.value) is own


def test_an_air_that_does_not_exist_is_refused_before_a_program_flies(tmp_path: Path):
    with pytest.raises(AirError, match="no_such_air"):
        licence(hop(tmp_path, LAND), LicenceOptions(air="no_such_air"))


WARM_UP = """
from q2q_model.compiled import KERNELS
from q2q_sim.experiments.licence.room.licence_room import LicenceParams, LicenceRoom
from q2q_sim.experiments.licence.room.trials import LicenceTrial

def called():
    return {(one.name, kind) for one in KERNELS for kind in getattr(one.made, "overloads", ())}

LicenceRoom(LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial()).fly()
warm = called()
"""


def test_the_warm_up_tick_calls_every_kernel_of_a_flight(tmp_path: Path):
    """The program warms up in the process of its flight, and lists what its flight calls beyond that."""
    program = hop(tmp_path, f"{LAND}\n    print(called() - warm)")
    program.file.write_text(WARM_UP + program.file.read_text())
    params = LicenceParams(((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    uris = ("radio://0/80/2M/E7E7E7E7E7", "radio://0/80/2M/E7E7E7E7E8")
    trial = LicenceTrial(TrialKind.SWAP, start=0.1, other=1)
    (flight,) = fly_trials([FlightOrder(program, params, trial, uris, (), 30.0)], LicenceOptions(), until=inf)
    assert flight.log is not None
    assert flight.log.output.splitlines()[-1] == "set()"


def test_a_program_for_the_multi_ranger_deck_sees_the_walls_of_the_licences_room(tmp_path: Path):
    look = f"""
    from cflib.utils.multiranger import Multiranger
    with Multiranger(scf) as ranger:
        time.sleep(0.5)
        print(ranger.front, ranger.back, ranger.left, ranger.right, ranger.up > 1.8, ranger.down < 0.6)
    {LAND}"""
    limits = LicenceLimits(half_room=(1.5, 5.0), ceiling=2.5)
    options = LicenceOptions(starts=((0.5, 0.0, 0.0),), limits=limits)
    order = FlightOrder(hop(tmp_path, look), options.params(1), LicenceTrial(), (), (), 30.0)
    (flight,) = fly_trials([order], options, until=float("inf"))
    assert flight.log is not None
    assert flight.findings == ()
    front, back, left, right, up, down = flight.log.output.splitlines()[-1].split()
    assert [float(front), float(back)] == pytest.approx([1.0, 2.0], abs=0.02)  # it hovers not quite still
    assert (left, right, up, down) == ("None", "None", "True", "True")
