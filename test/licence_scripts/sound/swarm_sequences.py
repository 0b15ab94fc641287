"""Two vehicles fly their own sequences of points, given as arguments."""

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


def sequence(scf: SyncCrazyflie, points: list) -> None:
    """Visit points (x, y, z, duration)."""
    for x, y, z, duration in points:
        scf.cf.high_level_commander.go_to(x, y, z, 0.0, duration)
        time.sleep(duration)


POINTS = {
    URIS[0]: [[(0.5, -0.5, 1.0, 2.0), (0.0, -0.5, 0.7, 2.0)]],
    URIS[1]: [[(-0.5, 0.5, 0.7, 2.0), (0.0, 0.5, 1.0, 2.0)]],
}


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.parallel_safe(arm)
        swarm.parallel_safe(take_off)
        swarm.parallel_safe(sequence, args_dict=POINTS)
        swarm.parallel_safe(land)
