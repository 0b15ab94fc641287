"""Vehicles whose emulated firmware executes RPYT setpoints: attitude and rate loops, mixer and motors.

The link has taken care of losses, locks and watchdogs (q2q_sim.link.radio); supervisor, estimator and battery
stay out of it: the attitude is the true one, and the supply is full. Everything else is the stock controller
of q2q_sim.firmware.controllers, at 500 Hz.
"""

import numpy as np

from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import (
    SET_ATTITUDE,
    SET_RATE,
    SET_THRUST,
    Power,
    setpoint_row,
)
from q2q_sim.firmware.firmware_tick import airframe_in, fly_tick, fresh_controllers
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.plant.swarm import Swarm

RPYT = Setpoint(roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY)
"""Modes of a setpoint of roll, pitch, yaw rate and thrust."""


class CommandedFlight:
    """Firmware of every vehicle of a swarm that flies by commands."""

    def __init__(self, swarm: Swarm, vehicle: Vehicle) -> None:
        """Start the firmware of a swarm of vehicles of one type."""
        n, airframe = len(swarm.names), airframe_in(swarm, vehicle)
        self._swarm, self._scale = swarm, RpytScale(vehicle.full_pwm_thrust)
        self._controllers = fresh_controllers(airframe, n)._replace(
            setpoints=np.tile(setpoint_row(RPYT, Power()), (n, 2, 1)),
            gains=np.tile(Parameters(airframe).gains(), (n, 1)),
        )

    def step(self, commands: Array, drive: Array) -> None:
        """Advance by one tick; arguments as those of Swarm.step, one row for each of its physics steps."""
        steps = iter(commands)
        if (commands == commands[0]).all():
            self._take(next(steps))
            fly_tick(self._swarm, self._controllers, drive)
            return
        fly_tick(self._swarm, self._controllers, drive, lambda: self._take(next(steps)))

    def _take(self, command: Array) -> None:
        """Take the commands of a step, (n, 4), in the firmware's units and signs: pitch is nose up there."""
        thrust, roll, pitch, yaw_rate = command.T
        rows = self._controllers.setpoints
        rows[:, :, SET_ATTITUDE] = np.degrees(roll)[:, None]
        rows[:, :, SET_ATTITUDE + 1] = -np.degrees(pitch)[:, None]
        rows[:, :, SET_RATE + 2] = np.degrees(yaw_rate)[:, None]
        rows[:, :, SET_THRUST] = self._scale.rpyt_pwm_of(thrust)[:, None]
