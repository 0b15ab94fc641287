"""Bug: goals in the world's frame are sent with relative=True."""

import numpy as np
from crazyflie_py import Crazyswarm

GOALS = ((1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0), (0.0, 0.0, 1.0))


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    for goal in GOALS:
        cf.goTo(np.array(goal), 0.0, 2.5, relative=True)
        timeHelper.sleep(3.0)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
