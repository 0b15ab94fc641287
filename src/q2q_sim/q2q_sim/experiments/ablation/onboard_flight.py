"""Flight of vehicles by their own emulated firmware, with or without the app on board.

Every vehicle flies full states by Mellinger's controller with its stock gains. Its own estimate of its motion
is exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from q2q_control.onboard.app_folder import write_app
from q2q_control.onboard.native_app import AppLibrary, compile_app
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, SwarmSetpoint
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.thrust_map import PWM_FULL
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.experiments.ablation.learned_models import LearnedModel
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.firmware_tick import MELLINGER
from q2q_sim.firmware.onboard_apps import AppConditions, OnboardApps
from q2q_sim.loop.closed_loop import ticks_of
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.loop.room import STEPS, Room
from q2q_sim.scenarios.scenario import Scenario

LOST = 0.2
"""Share of broadcasts that do not arrive."""
RADIO_RANGE = 5.0
"""Of a broadcast [m]: other draws do not receive it."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Measured quantities of a flight of n vehicles."""

    pos: Array
    """True positions [m], world, (T, n, 3)."""
    error: Array
    """True minus planned height [m], (T, n)."""


def fly_on_board(
    scenario: Scenario, models: Sequence[LearnedModel], air: FlownAir, seed: int, *, apps: bool
) -> Trace:
    """Return a flight by the vehicles' own firmware; `models` are those of their apps, one per vehicle."""
    room = Room(scenario, seed, air)
    fleet = Fleet(room.swarm, scenario.vehicle, Build(), _apps(scenario, models, seed) if apps else None)
    choose_mellinger(fleet, scenario.vehicle)
    plan = plan_of(scenario)
    pos = np.empty((ticks_of(scenario), len(scenario.names), 3))
    error = np.empty(pos.shape[:2])
    for tick in range(len(pos)):
        wanted = setpoint_at(plan, tick * TICK_S)
        send_full_states(fleet, wanted)
        pos[tick] = room.swarm.state[:, :3]
        error[tick] = pos[tick, :, 2] - wanted.pos[:, 2]
        room.fly(fleet.fly)
    return Trace(pos, error)


def choose_mellinger(fleet: Fleet, vehicle: Vehicle) -> None:
    """Select Mellinger's controller, with the thrust map of the vehicle."""
    for one in fleet.vehicles:
        one.firmware.parameters.set("stabilizer.controller", MELLINGER)
        one.firmware.parameters.set("ctrlMel.massThrust", PWM_FULL / vehicle.full_pwm_thrust)


def send_full_states(fleet: Fleet, wanted: SwarmSetpoint) -> None:
    """Send a tick's full states."""
    x, y, z, yaw = [Mode.ABS] * 4
    states = zip(wanted.pos.tolist(), wanted.vel.tolist(), wanted.acc.tolist(), strict=True)
    for vehicle, (pos, vel, acc) in zip(fleet.vehicles, states, strict=True):
        vehicle.handle(ECHO_REQUEST)
        vehicle.firmware.accept(
            Setpoint(x=x, y=y, z=z, yaw=yaw, pos=tuple(pos), vel=tuple(vel), acc=tuple(acc))
        )


def _apps(scenario: Scenario, models: Sequence[LearnedModel], seed: int) -> OnboardApps:
    noise = sqrt(STEPS) * scenario.imu.acc_noise  # white, five samples per tick
    conditions = AppConditions(LOST, noise, scenario.imu.acc_bias, RADIO_RANGE)
    libraries = [_library(model, scenario.vehicle) for model in models]
    return OnboardApps(libraries, conditions, seed)


@lru_cache(maxsize=16)
def _library(model: LearnedModel, vehicle: Vehicle) -> AppLibrary:
    with TemporaryDirectory() as made:
        write_app(Path(made) / "app", ModelFile(model.jet, residual=model.residual), vehicle)
        return compile_app(Path(made) / "app")
