"""The firmware app flies on the emulated firmware, in air that its model does not know."""

import shutil
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from q2q_control.onboard.app_folder import write_app
from q2q_control.onboard.native_app import AppBuildError, AppLibrary, NativeApp, StepInput, compile_app
from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import SwarmSetpoint
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.onboard_apps import AppConditions, OnboardApps
from q2q_sim.loop.room import Room
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.scenarios.scenario_document import scenario_from_document

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None, reason="no C compiler: install one to fly the app"
)
MELLINGER = 2
EXACT = 65535 / CRAZYFLIE_2_0.full_pwm_thrust
"""massThrust [1/N] that makes up for the weight."""
FLOWN = AppConditions(broadcast_loss=0.2, acc_noise=0.45, acc_bias=0.05)
"""Accelerometer as of the residual process: 0.2 m/s^2 at 100 Hz."""
PASS = {
    "duration": 5.5,
    "vehicles": {
        "cf1": [{"t": 0, "pos": [0, -0.6, 1]}, {"t": 1, "pos": [0, -0.6, 1]}, {"t": 5, "pos": [0, 0.6, 1]}],
        "cf2": [{"t": 0, "pos": [0, 0, 1.5]}, {"t": 5, "pos": [0, 0, 1.5]}],
    },
}
"""One vehicle passes 0.5 m under another."""


@lru_cache(maxsize=1)
def library_of_app() -> AppLibrary:
    with TemporaryDirectory() as made:
        write_app(Path(made) / "app", ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
        return compile_app(Path(made) / "app")


@lru_cache(maxsize=4)
def worst_under(conditions: AppConditions | None) -> tuple[float, float]:
    """Return the largest height error under another vehicle and the rms in clear air [m], by Mellinger."""
    scenario, seed = scenario_from_document("pass", PASS), 3
    # without the edge torque: it topples the emulated Mellinger controller, with an app and without
    room = Room(scenario, seed, find_air("room", ("edge_torque",)))
    apps = conditions and OnboardApps([library_of_app()] * 2, conditions, seed)
    fleet = Fleet(room.swarm, scenario.vehicle, Build(), apps)
    plan = minimum_snap_plan(scenario.waypoints, scenario.reading)
    pos, error = np.empty((2, round(scenario.duration / TICK_S), 2, 3))
    for tick in range(len(pos)):
        wanted = setpoint_at(plan, tick * TICK_S)
        send(fleet, wanted)
        pos[tick] = room.swarm.state[:, :3]
        error[tick] = pos[tick] - wanted.pos
        room.fly(fleet.fly)
    when, height = exposure(pos, TICK_S * np.arange(len(pos))), error[..., 2]
    return float(np.abs(height[when.under]).max()), float(np.sqrt(np.mean(height[when.clear] ** 2)))


def send(fleet: Fleet, wanted: SwarmSetpoint) -> None:
    """Send a tick's full states to Mellinger's controller."""
    x, y, z, yaw = [Mode.ABS] * 4
    for i, vehicle in enumerate(fleet.vehicles):
        vehicle.firmware.parameters.set("stabilizer.controller", MELLINGER)
        vehicle.firmware.parameters.set("ctrlMel.massThrust", EXACT)
        vehicle.handle(ECHO_REQUEST)
        pos, vel, acc = (tuple(part[i]) for part in (wanted.pos, wanted.vel, wanted.acc))
        vehicle.firmware.accept(Setpoint(x=x, y=y, z=z, yaw=yaw, pos=pos, vel=vel, acc=acc))


def test_with_the_app_a_vehicle_passes_under_another_with_a_third_of_the_height_error() -> None:
    ignoring, app = worst_under(None), worst_under(FLOWN)
    assert ignoring[0] > 0.04
    assert app[0] < 0.4 * ignoring[0]
    assert app[1] < ignoring[1] + 0.002  # the noise of the accelerometer


def test_without_broadcasts_the_correction_alone_still_helps() -> None:
    assert worst_under(replace(FLOWN, broadcast_loss=1.0))[0] < 0.8 * worst_under(None)[0]


@pytest.mark.parametrize("heavier", [1.0, 2.0])
def test_an_app_takes_mass_and_thrust_of_its_header_whatever_vehicle_flies(
    heavier: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A header of another vehicle or firmware flew like the right one, and then not so on real vehicles."""
    exported, known = replace(CRAZYFLIE_2_0, mass=heavier * CRAZYFLIE_2_0.mass), list[StepInput]()

    def step(_: NativeApp, one: StepInput) -> float:
        known.append(one)
        return 0.0

    monkeypatch.setattr(NativeApp, "step", step)
    write_app(tmp_path, ModelFile(MEASURED_LAW), exported)
    scenario = scenario_from_document("pass", PASS)
    room = Room(scenario, 0, find_air("measured"))
    fleet = fleet_in(room, scenario, CrtpRoomParams(start="air", app=str(tmp_path)))
    plan = minimum_snap_plan(scenario.waypoints, scenario.reading)
    for tick in range(100):
        send(fleet, setpoint_at(plan, tick * TICK_S))
        room.fly(fleet.fly)
    hovering = np.mean([one.thrust for one in known[-200:]])
    assert hovering == pytest.approx(GRAVITY / heavier, rel=0.02)


def test_a_folder_of_an_earlier_export_is_refused(tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    code = tmp_path / "q2q_app.c"
    code.write_text(
        code.read_text(encoding="utf-8").replace("q2q_acc_per_pwm", "q2q_other"), encoding="utf-8"
    )
    with pytest.raises(AppBuildError, match="of an earlier export_app: export it again"):
        compile_app(tmp_path)


def test_a_room_of_crtp_clients_flies_an_exported_app(tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    scenario = scenario_from_document("pass", PASS)
    room = Room(scenario, 0, find_air("measured"))
    fleet = fleet_in(room, scenario, CrtpRoomParams(start="air", app=str(tmp_path)))
    plan = minimum_snap_plan(scenario.waypoints, scenario.reading)
    for tick in range(60):
        send(fleet, setpoint_at(plan, tick * TICK_S))
        room.fly(fleet.fly)
    assert fleet.apps is not None
    assert np.isfinite(fleet.apps.eta).all()
    assert np.abs(fleet.apps.eta).max() > 0.0
    with pytest.raises(AppBuildError, match="is not an app of export_app"):
        fleet_in(room, scenario, CrtpRoomParams(app=str(tmp_path / "none")))
