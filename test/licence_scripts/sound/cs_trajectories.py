"""Three vehicles fly one trajectory of a CSV file forwards and backwards."""

import tempfile
from pathlib import Path

import numpy as np
from crazyflie_py import Crazyswarm
from crazyflie_py.uav_trajectory import Trajectory

DURATION = 4.0
RISE = (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)
"""Rest to rest from 0 to 1 in one unit of time: coefficients of rising powers."""


def csv_text() -> str:
    """Return a file of two pieces: 0.8 m forward, then back."""
    scaled = np.array(RISE) / DURATION ** np.arange(8)
    there, back = 0.8 * scaled, np.eye(8)[0] * 0.8 - 0.8 * scaled
    rows = [[DURATION, *x, *np.zeros(8), *np.zeros(8), *np.zeros(8)] for x in (there, back)]
    head = ",".join(["duration", *(f"{axis}^{k}" for axis in ("x", "y", "z", "yaw") for k in range(8))])
    return "\n".join([head, *(",".join(f"{one:.9g}" for one in row) for row in rows)]) + "\n"


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs
    file = Path(tempfile.mkdtemp()) / "there_and_back.csv"
    file.write_text(csv_text())
    trajectory = Trajectory()
    trajectory.loadcsv(file)
    for cf in allcfs.crazyflies:
        cf.uploadTrajectory(0, 0, trajectory)

    allcfs.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(2.5)
    allcfs.startTrajectory(0, timescale=1.0)
    timeHelper.sleep(trajectory.duration + 1.0)
    allcfs.startTrajectory(0, timescale=1.2, reverse=True)
    timeHelper.sleep(1.2 * trajectory.duration + 1.0)
    allcfs.land(targetHeight=0.06, duration=2.0)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
