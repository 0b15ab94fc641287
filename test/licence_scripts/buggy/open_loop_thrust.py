"""Bug: a constant thrust in place of a height."""

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
        cf.commander.send_setpoint(0, 0, 0, 0)
        for thrust, steps in ((48000, 30), (44000, 40), (38000, 40)):
            for _ in range(steps):
                cf.commander.send_setpoint(0, 0, 0, thrust)
                time.sleep(0.05)
        cf.commander.send_setpoint(0, 0, 0, 0)
        time.sleep(0.1)
