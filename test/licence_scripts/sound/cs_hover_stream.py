"""Fly forwards and backwards by hover setpoints at 10 Hz, turning, then land."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]

    cf.takeoff(targetHeight=0.6, duration=2.0)
    timeHelper.sleep(2.5)
    for vx, yaw_rate, seconds in ((0.3, 0.0, 3.0), (-0.3, 0.0, 3.0), (0.0, 0.8, 2.0), (0.0, 0.0, 1.0)):
        for _ in range(round(10 * seconds)):
            cf.cmdHover(vx, 0.0, yaw_rate, 0.6)
            timeHelper.sleep(0.1)
    cf.notifySetpointsStop(remainValidMillisecs=200)
    cf.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
