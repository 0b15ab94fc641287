"""Bug: the motors are cut before the landing, of 3 s, is over."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    allcfs.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(3.0)
    allcfs.land(targetHeight=0.04, duration=3.0)
    timeHelper.sleep(1.5)
    allcfs.emergency()
    timeHelper.sleep(1.0)


if __name__ == "__main__":
    main()
