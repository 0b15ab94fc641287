"""Bounce between two sides of a box by the logged position, as a deck makes it known."""

import time
from threading import Event

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.motion_commander import MotionCommander
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        deck = Event()
        cf.param.add_update_callback(
            group="deck", name="bcFlow2", cb=lambda _, value: deck.set() if int(value) else None
        )
        if not deck.wait(5.0):
            raise SystemExit("no flow deck")
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        place = [0.0]
        config = LogConfig(name="place", period_in_ms=20)
        config.add_variable("stateEstimate.x", "float")
        cf.log.add_config(config)
        config.data_received_cb.add_callback(
            lambda _, data, __: place.__setitem__(0, data["stateEstimate.x"])
        )
        config.start()
        with MotionCommander(scf, default_height=0.5) as mc:
            speed = 0.3
            for _ in range(150):
                if abs(place[0]) > 0.5:
                    speed = -0.3 if place[0] > 0.0 else 0.3
                mc.start_linear_motion(speed, 0.0, 0.0)
                time.sleep(0.1)
        config.stop()
