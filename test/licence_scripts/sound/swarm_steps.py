"""Four vehicles fly a square by relative steps at once."""

import time

import cflib.crtp
from cflib.crazyflie.swarm import CachedCfFactory, Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

URIS = (
    "radio://0/80/2M/E7E7E7E701",
    "radio://0/80/2M/E7E7E7E702",
    "radio://0/80/2M/E7E7E7E703",
    "radio://0/80/2M/E7E7E7E704",
)


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


def square(scf: SyncCrazyflie) -> None:
    """Fly a square."""
    for x, y in ((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)):
        scf.cf.high_level_commander.go_to(x, y, 0.0, 0.0, 2.0, relative=True)
        time.sleep(2.2)


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.reset_estimators()
        swarm.parallel_safe(arm)
        swarm.parallel_safe(take_off)
        swarm.parallel_safe(square)
        swarm.parallel_safe(land)
