"""Bug: flies to a point by body velocities turned by the yaw with the wrong sign."""

import math
import time

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
        hl = cf.high_level_commander
        hl.takeoff(0.8, 2.0, yaw=None)
        time.sleep(2.5)
        place = {}
        config = LogConfig(name="pose", period_in_ms=20)
        for name in ("x", "y", "yaw"):
            config.add_variable(f"stateEstimate.{name}" if name != "yaw" else "stabilizer.yaw", "float")
        cf.log.add_config(config)
        config.data_received_cb.add_callback(lambda _, data, __: place.update(data))
        config.start()
        time.sleep(0.2)
        for _ in range(150):
            yaw = -math.radians(place["stabilizer.yaw"])
            dx, dy = 0.5 - place["stateEstimate.x"], 0.5 - place["stateEstimate.y"]
            forward = math.cos(yaw) * dx + math.sin(yaw) * dy
            left = -math.sin(yaw) * dx + math.cos(yaw) * dy
            cf.commander.send_hover_setpoint(forward, left, 0, 0.8)
            time.sleep(0.1)
        cf.commander.send_notify_setpoint_stop()
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
