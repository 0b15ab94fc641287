"""Two vehicles change places at one height, each around its own side."""

import numpy as np
from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    one, other = (swarm.allcfs.crazyfliesByName[name] for name in ("cf1", "cf2"))
    here, there = (np.array(cf.initialPosition) + np.array([0.0, 0.0, 0.8]) for cf in (one, other))
    middle, side = 0.5 * (here + there), np.array([0.6, 0.0, 0.0])

    swarm.allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(2.5)
    if min(cf.get_position()[2] for cf in (one, other)) < 0.5:
        swarm.allcfs.land(targetHeight=0.04, duration=2.0)
        timeHelper.sleep(2.5)
        return
    one.goTo(middle + side, 0.0, 2.5)
    other.goTo(middle - side, 0.0, 2.5)
    timeHelper.sleep(3.0)
    one.goTo(there, 0.0, 2.5)
    other.goTo(here, 0.0, 2.5)
    timeHelper.sleep(3.0)
    for cf in (one, other):
        cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
