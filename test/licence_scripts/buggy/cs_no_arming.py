"""Bug: the vehicles must be armed, and are not."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(4.0)
    allcfs.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
