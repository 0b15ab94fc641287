"""Visit points by PositionHlCommander."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.position_hl_commander import PositionHlCommander
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        with PositionHlCommander(
            scf, default_height=0.6, controller=PositionHlCommander.CONTROLLER_PID
        ) as pc:
            pc.forward(0.6)
            pc.left(0.4)
            pc.go_to(0.0, 0.0, 1.0)
