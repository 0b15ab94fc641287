"""Bug: the yaw of goTo is in degrees."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]
    home = np.array(cf.initialPosition) + np.array([0.0, 0.0, 1.0])

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    for yaw in (90, 180, 270, 0):
        cf.goTo(home, yaw, 2.0)
        timeHelper.sleep(2.5)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
