"""Fly a circle by full states at 100 Hz, hand over and land."""

import numpy as np
from crazyflie_py import Crazyswarm

RADIUS = 0.5
RATE = 2.0 * np.pi / 6.0


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]
    centre = np.array(cf.initialPosition) + np.array([-RADIUS, 0.0, 1.0])

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    start = timeHelper.time()
    while not timeHelper.isShutdown():
        t = timeHelper.time() - start
        if t > 12.0:
            break
        c, s = np.cos(RATE * t), np.sin(RATE * t)
        cf.cmdFullState(
            centre + RADIUS * np.array([c, s, 0.0]),
            RADIUS * RATE * np.array([-s, c, 0.0]),
            RADIUS * RATE**2 * np.array([-c, -s, 0.0]),
            0.0,
            np.zeros(3),
        )
        timeHelper.sleepForRate(100)
    cf.notifySetpointsStop()
    cf.goTo(centre + np.array([RADIUS, 0.0, 0.0]), 0.0, 2.0)
    timeHelper.sleep(2.5)
    cf.land(targetHeight=0.03, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
