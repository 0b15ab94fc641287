"""Bug: no notifySetpointsStop before the landing, which streamed setpoints outrank."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]
    home = np.array(cf.initialPosition) + np.array([0.0, 0.0, 0.8])

    cf.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(2.5)
    for _ in range(300):
        cf.cmdFullState(home, np.zeros(3), np.zeros(3), 0.0, np.zeros(3))
        timeHelper.sleepForRate(100)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
