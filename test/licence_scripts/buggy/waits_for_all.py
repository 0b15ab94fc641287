"""Bug: waits in the air until all have risen, without a limit."""

import time

import cflib.crtp
from cflib.crazyflie.log import LogConfig
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


def rise(scf: SyncCrazyflie) -> None:
    """Take off and wait until the vehicle has risen."""
    height = [0.0]
    config = LogConfig(name="height", period_in_ms=100)
    config.add_variable("stateEstimate.z", "float")
    scf.cf.log.add_config(config)
    config.data_received_cb.add_callback(lambda _, data, __: height.__setitem__(0, data["stateEstimate.z"]))
    config.start()
    scf.cf.high_level_commander.takeoff(1.0, 2.0)
    while height[0] < 0.9:
        time.sleep(0.1)


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    with Swarm(URIS, factory=CachedCfFactory()) as swarm:
        swarm.parallel_safe(arm)
        swarm.parallel_safe(rise)
        swarm.parallel_safe(land)
