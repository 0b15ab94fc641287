"""Bug: steps meant relative are sent without relative=True, to both vehicles."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(2.5)
    for cf in allcfs.crazyflies:
        cf.goTo([0.3, 0.0, 0.2], 0.0, 2.0)
    timeHelper.sleep(2.5)
    allcfs.land(targetHeight=0.04, duration=2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
