"""Arm two vehicles that do not arm themselves, fly, land and disarm."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    for cf in allcfs.crazyflies:
        cf.arm(True)
        timeHelper.sleep(0.5)
    timeHelper.sleep(1.0)
    allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(4.0)
    allcfs.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(3.0)
    allcfs.arm(False)
    timeHelper.sleep(1.0)


if __name__ == "__main__":
    main()
