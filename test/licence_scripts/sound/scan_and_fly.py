"""Scan, and hover with the first vehicle that is found."""

import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

if __name__ == "__main__":
    cflib.crtp.init_drivers()
    found = cflib.crtp.scan_interfaces()
    if not found:
        raise SystemExit("no vehicle")
    with SyncCrazyflie(found[0][0], cf=Crazyflie()) as scf:
        commander = scf.cf.high_level_commander
        scf.cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        commander.takeoff(0.5, 1.5)
        time.sleep(3.0)
        commander.land(0.0, 1.5)
        time.sleep(2.0)
        commander.stop()
