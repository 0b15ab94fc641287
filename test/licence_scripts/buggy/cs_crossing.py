"""Bug: two vehicles swap places 0.35 m above each other, slowly, in the downwash."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs
    low, high = allcfs.crazyflies
    up = {low.prefix: np.array([0.0, 0.0, 0.7]), high.prefix: np.array([0.0, 0.0, 1.05])}

    allcfs.takeoff(targetHeight=0.7, duration=2.0)
    timeHelper.sleep(2.5)
    for cf in (low, high):
        cf.goTo(np.array(cf.initialPosition) + up[cf.prefix], 0.0, 2.0)
    timeHelper.sleep(2.5)
    low.goTo(np.array(high.initialPosition) + up[low.prefix], 0.0, 5.0)
    high.goTo(np.array(low.initialPosition) + up[high.prefix], 0.0, 5.0)
    timeHelper.sleep(5.5)
    allcfs.land(targetHeight=0.04, duration=2.5)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
