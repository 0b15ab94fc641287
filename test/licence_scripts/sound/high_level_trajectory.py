"""Upload a straight trajectory of one polynomial and fly it."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.mem import MemoryElement, Poly4D
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.utils import uri_helper

URI = uri_helper.uri_from_env(default="radio://0/80/2M/E7E7E7E7E7")


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with SyncCrazyflie(URI, cf=Crazyflie()) as scf:
        cf = scf.cf
        cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        piece = Poly4D(
            3.0,
            Poly4D.Poly([0.0, 0.0, 0.0, 0.370370, -0.185185, 0.024691, 0.0, 0.0]),
            Poly4D.Poly([0.0] * 8),
            Poly4D.Poly([0.0] * 8),
            Poly4D.Poly([0.0] * 8),
        )
        memory = cf.mem.get_mems(MemoryElement.TYPE_TRAJ)[0]
        memory.trajectory = [piece]
        if not memory.write_data_sync():
            raise SystemExit("the trajectory was not stored")
        cf.high_level_commander.define_trajectory(1, 0, 1)
        hl = cf.high_level_commander
        hl.takeoff(0.8, 2.0)
        time.sleep(2.5)
        hl.start_trajectory(1, 1.0, relative_position=True)
        time.sleep(3.5)
        hl.land(0.0, 2.0)
        time.sleep(2.5)
        hl.stop()
