"""Four vehicles in two groups: the first group flies and lands, then the second."""

from crazyflie_py import Crazyswarm

EVEN, ODD = 0b01, 0b10


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    for number, cf in enumerate(allcfs.crazyflies):
        cf.setGroupMask(ODD if number % 2 else EVEN)
    for group in (EVEN, ODD):
        allcfs.takeoff(targetHeight=0.7, duration=2.0, groupMask=group)
        timeHelper.sleep(2.5)
        allcfs.goTo([0.4, 0.0, 0.2], 0.0, 2.0, groupMask=group)
        timeHelper.sleep(2.5)
        allcfs.land(targetHeight=0.04, duration=2.0, groupMask=group)
        timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
