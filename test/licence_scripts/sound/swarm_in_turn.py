"""One after the other takes off, if it is ready within a second, and lands."""

import time

import cflib.crtp
from cflib.crazyflie.swarm import CachedCfFactory, Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

URIS = ("radio://0/80/2M/E7E7E7E701", "radio://0/80/2M/E7E7E7E702")


def hop(scf: SyncCrazyflie) -> None:
    """Hop, if the vehicle can fly."""
    scf.cf.supervisor.send_arming_request(True)
    for _ in range(10):
        time.sleep(0.1)
        if scf.cf.supervisor.can_fly:
            break
    else:
        print("cannot fly", scf.cf.link_uri)
        return
    scf.cf.high_level_commander.takeoff(0.6, 1.5)
    time.sleep(2.5)
    scf.cf.high_level_commander.land(0.0, 1.5)
    time.sleep(2.0)
    scf.cf.high_level_commander.stop()


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.sequential(hop)
