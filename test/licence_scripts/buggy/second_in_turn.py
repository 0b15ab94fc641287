"""Bug: the second vehicle, connected after the first has landed, is stopped in the air."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

URIS = ("radio://0/80/2M/E7E7E7E701", "radio://0/80/2M/E7E7E7E702")


def hop(scf: SyncCrazyflie, *, lands: bool) -> None:
    """Take off, and land or not."""
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(1.0)
    scf.cf.high_level_commander.takeoff(0.6, 1.5)
    time.sleep(2.5)
    if lands:
        scf.cf.high_level_commander.land(0.0, 1.5)
        time.sleep(2.0)
    scf.cf.high_level_commander.stop()


if __name__ == "__main__":
    cflib.crtp.init_drivers()
    for uri in URIS:
        with SyncCrazyflie(uri, cf=Crazyflie()) as scf:
            hop(scf, lands=uri == URIS[0])
