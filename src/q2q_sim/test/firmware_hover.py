"""A hovering vehicle of the emulated firmware, for tests."""

import numpy as np

from q2q_sim.crtp.pilot import Pilot
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.firmware_build import Build

HOVER = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.0))


def hovering(**build: bool) -> Pilot:
    """Return a vehicle that has hovered for 3 s."""
    pilot = Pilot(np.array([[0.0, 0.0, 1.0, 0.0]]), build=Build(**build))
    pilot.fly(3.0, pilot.hold(HOVER))
    return pilot
