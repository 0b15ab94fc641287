"""Bug: takes off and lands with the first vehicle only."""

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


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.parallel_safe(arm)
        first = swarm._cfs[URIS[0]]
        take_off(first)
        land(first)
