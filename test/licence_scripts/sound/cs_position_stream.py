"""Hold two vehicles by streamed positions until a button is pressed, then land."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    allcfs.takeoff(targetHeight=0.5, duration=1.5)
    timeHelper.sleep(2.0)
    while not swarm.input.checkIfButtonIsPressed():
        for cf in allcfs.crazyflies:
            cf.cmdPosition(np.array(cf.initialPosition) + np.array([0.2, 0.0, 0.5]), yaw=0.0)
        timeHelper.sleepForRate(20)
    for cf in allcfs.crazyflies:
        cf.notifySetpointsStop()
        cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
