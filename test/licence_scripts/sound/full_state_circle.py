"""Take off, fly a circle by full states at 50 Hz, hand over and land."""

import math
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
        for k in range(400):
            angle = 2.0 * math.pi * k / 400
            pos = (0.5 * math.cos(angle) - 0.5, 0.5 * math.sin(angle), 0.8)
            rate = 2.0 * math.pi / 8.0
            vel = (-0.5 * rate * math.sin(angle), 0.5 * rate * math.cos(angle), 0.0)
            cf.commander.send_full_state_setpoint(
                pos, vel, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), 0.0, 0.0, 0.0
            )
            time.sleep(0.02)
        cf.commander.send_notify_setpoint_stop()
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
