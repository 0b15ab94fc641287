"""Hover until time is up or the battery is low, whichever is first, then land."""

import time
from threading import Event

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        config = LogConfig(name="battery", period_in_ms=100)
        config.add_variable("pm.vbat", "float")
        low = Event()
        cf.log.add_config(config)
        config.data_received_cb.add_callback(lambda _, data, __: low.set() if data["pm.vbat"] < 3.4 else None)
        config.start()
        hl = cf.high_level_commander
        hl.takeoff(0.8, 2.0)
        time.sleep(2.5)
        low.wait(6.0)
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
