"""Stream positions at 10 Hz down to the floor, after a reset of the estimator."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.utils import uri_helper
from cflib.utils.reset_estimator import reset_estimator

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        reset_estimator(scf)
        for x, y, z in (
            (0.0, 0.0, 0.5),
            (0.0, 0.0, 1.0),
            (0.6, -0.6, 1.0),
            (0.0, 0.0, 1.0),
            (0.0, 0.0, 0.4),
            (0.0, 0.0, 0.1),
        ):
            for _ in range(30):
                cf.commander.send_position_setpoint(x, y, z, 0)
                time.sleep(0.1)
        cf.commander.send_stop_setpoint()
        cf.commander.send_notify_setpoint_stop()
        time.sleep(0.1)
