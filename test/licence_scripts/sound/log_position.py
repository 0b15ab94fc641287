"""Log the estimated position for two seconds, without flying."""

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")

if __name__ == "__main__":
    cflib.crtp.init_drivers()
    config = LogConfig(name="place", period_in_ms=100)
    config.add_variable("stateEstimate.x", "float")
    config.add_variable("pm.vbat", "float")
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf, SyncLogger(scf, config) as logger:
        for number, (stamp, values, _) in enumerate(logger):
            print(stamp, values)
            if number >= 20:
                break
