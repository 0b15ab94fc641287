"""Climb, circle and descend by hover setpoints."""

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

        def hold(seconds, forward, turn, first, last):
            """Stream a speed and a turn rate while the height goes from one value to another."""
            steps = int(10 * seconds)
            for k in range(steps):
                cf.commander.send_hover_setpoint(forward, 0, turn, first + (last - first) * (k + 1) / steps)
                time.sleep(0.1)

        hold(2.0, 0.0, 0.0, 0.0, 0.5)
        hold(6.0, 0.3, 60.0, 0.5, 0.5)
        hold(2.0, 0.0, 0.0, 0.5, 0.05)
        cf.commander.send_stop_setpoint()
        cf.commander.send_notify_setpoint_stop()
        time.sleep(0.1)
