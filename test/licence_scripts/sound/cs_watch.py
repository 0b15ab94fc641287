"""Hover while the battery and the position are as they should be, at most 8 s, then land."""

import numpy as np
from crazyflie_py import Crazyswarm


def fine(cf: object, home: np.ndarray) -> bool:
    """Return whether a vehicle may fly on."""
    status = cf.get_status()
    weak = bool(status) and (status["pm_state"] == 3 or status["battery"] < 3.6)
    away = np.linalg.norm(np.array(cf.get_position()) - home) > 0.5
    return not weak and not away


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyfliesById[231]
    if cf.getParam("stabilizer.estimator") != 2:
        print("another estimator")
    cf.setParam("ring.effect", 7)
    home = np.array(cf.initialPosition) + np.array([0.0, 0.0, 0.7])

    cf.takeoff(targetHeight=0.7, duration=2.0)
    timeHelper.sleep(3.0)
    end = timeHelper.time() + 8.0
    while timeHelper.time() < end and fine(cf, home):
        timeHelper.sleep(0.2)
    cf.land(targetHeight=0.04, duration=2.5)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
