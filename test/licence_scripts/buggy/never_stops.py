"""Bug: the velocity along x is never set back to 0."""

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
        for vx, vz, steps in ((0.0, 0.5, 20), (0.6, 0.0, 80), (0.6, -0.3, 30)):
            for _ in range(steps):
                cf.commander.send_velocity_world_setpoint(vx, 0.0, vz, 0.0)
                time.sleep(0.1)
        cf.commander.send_stop_setpoint()
