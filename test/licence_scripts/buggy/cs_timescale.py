"""Bug: the time scale is inverted, so that the trajectory is flown five times too fast."""

import numpy as np
from crazyflie_py import Crazyswarm
from crazyflie_py.uav_trajectory import Polynomial4D, Trajectory

RISE = np.array((0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0))
"""Rest to rest from 0 to 1 in one unit of time: coefficients of rising powers."""


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]
    trajectory = Trajectory()
    trajectory.polynomials = [
        Polynomial4D(2.0, 1.5 * RISE / 2.0 ** np.arange(8), np.zeros(8), np.zeros(8), np.zeros(8))
    ]
    trajectory.duration = 2.0
    cf.uploadTrajectory(1, 0, trajectory)

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    cf.startTrajectory(1, timescale=1.0 / 5.0)
    timeHelper.sleep(5.0 * trajectory.duration)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
