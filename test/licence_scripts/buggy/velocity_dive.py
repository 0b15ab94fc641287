"""Bug: the velocity of the landing is -3 m/s, meant is -0.3."""

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
        cf.high_level_commander.takeoff(2.0, 3.0)
        time.sleep(3.5)
        for _ in range(50):
            cf.commander.send_velocity_world_setpoint(0.0, 0.0, -3.0, 0.0)
            time.sleep(0.05)
        cf.commander.send_stop_setpoint()
        cf.commander.send_notify_setpoint_stop()
        time.sleep(0.1)
