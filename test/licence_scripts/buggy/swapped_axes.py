"""Bug: x and y of the second vehicle's point (-0.5, 0.6) are swapped, which is where the first goes."""

import time

import cflib.crtp
from cflib.crazyflie.swarm import CachedCfFactory, Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

URIS = ("radio://0/80/2M/E7E7E7E701", "radio://0/80/2M/E7E7E7E702")


def arm(scf: SyncCrazyflie) -> None:
    """Arm one vehicle."""
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(1.0)


def take_off(scf: SyncCrazyflie) -> None:
    """Take off and wait."""
    scf.cf.high_level_commander.takeoff(1.0, 2.0)
    time.sleep(2.5)


def land(scf: SyncCrazyflie) -> None:
    """Land and stop the motors."""
    scf.cf.high_level_commander.land(0.0, 2.0)
    time.sleep(2.5)
    scf.cf.high_level_commander.stop()


def fly(scf: SyncCrazyflie, x: float, y: float) -> None:
    """Go to a point."""
    scf.cf.high_level_commander.go_to(x, y, 1.0, 0.0, 3.0)
    time.sleep(3.5)


POINTS = {URIS[0]: (0.6, -0.5), URIS[1]: (0.6, -0.5)}


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.parallel_safe(arm)
        swarm.parallel_safe(take_off)
        swarm.parallel_safe(fly, args_dict=POINTS)
        swarm.parallel_safe(land)
