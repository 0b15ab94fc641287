"""Bug: x and y of the second vehicle's circle are swapped, so that it meets the first."""

import numpy as np
from crazyflie_py import Crazyswarm

SECONDS = 6.0


def main() -> None:
    """Fly two circles of 0.5 m around (-0.4, 0.6) and (0.6, -0.4)."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    one, other = swarm.allcfs.crazyflies
    centres = {one.prefix: np.array([-0.4, 0.6, 0.8]), other.prefix: np.array([-0.4, 0.6, 0.8])}

    swarm.allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(2.5)
    start = timeHelper.time()
    while timeHelper.time() < start + SECONDS:
        angle = 2.0 * np.pi * (timeHelper.time() - start) / SECONDS
        arm = 0.5 * np.array([np.cos(angle), np.sin(angle), 0.0])
        for cf in (one, other):
            cf.cmdFullState(centres[cf.prefix] + arm, np.zeros(3), np.zeros(3), 0.0, np.zeros(3))
        timeHelper.sleepForRate(50)
    for cf in (one, other):
        cf.notifySetpointsStop()
        cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
