"""Bug: moves with a MotionCommander that has not taken off."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.motion_commander import MotionCommander
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        mc = MotionCommander(scf)
        mc.forward(0.5)
        mc.land()
