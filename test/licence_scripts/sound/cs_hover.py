"""Take off, go to a point, turn there, go back and land."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]
    home = np.array(cf.initialPosition)

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    cf.goTo(home + np.array([0.6, -0.4, 1.2]), 0.0, 3.0)
    timeHelper.sleep(3.5)
    cf.goTo(home + np.array([0.6, -0.4, 1.2]), np.pi / 2, 2.0)
    timeHelper.sleep(2.5)
    cf.goTo(home + np.array([0.0, 0.0, 1.0]), 0.0, 3.0)
    timeHelper.sleep(3.5)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
