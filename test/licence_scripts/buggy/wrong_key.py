"""Bug: reads a variable in flight that it does not log."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger
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
        config = LogConfig(name="place", period_in_ms=100)
        config.add_variable("stateEstimate.x", "float")
        with SyncLogger(scf, config) as logger:
            for _, data, _ in logger:
                if data["stateEstimate.y"] > -1.0:
                    break
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
