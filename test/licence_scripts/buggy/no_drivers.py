"""Bug: the drivers are not initialised."""

import time

from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.motion_commander import MotionCommander

if __name__ == "__main__":
    with SyncCrazyflie("radio://0/80/2M/E7E7E7E7E7") as scf, MotionCommander(scf):
        time.sleep(2.0)
