"""Bug: lands by the high-level commander while setpoints have priority."""

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
        hl = cf.high_level_commander
        hl.takeoff(0.8, 2.0)
        time.sleep(2.5)
        for _ in range(20):
            cf.commander.send_position_setpoint(0.4, 0.0, 0.8, 0)
            time.sleep(0.1)
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
