"""Bug: no setpoint of thrust 0 unlocks the thrust."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        for _ in range(30):
            cf.commander.send_setpoint(0, 0, 0, 45000)
            time.sleep(0.05)
        cf.commander.send_setpoint(0, 0, 0, 0)
