"""Bug: setpoints every 0.9 s, slower than the firmware's watchdog of 0.5 s."""

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
        for z in (0.4, 0.6, 0.6, 0.6, 0.6, 0.6, 0.4, 0.2, 0.1, 0.05):
            cf.commander.send_position_setpoint(0.0, 0.0, z, 0)
            time.sleep(0.9)
        cf.commander.send_stop_setpoint()
        time.sleep(0.1)
