"""Bug: the group mask is taken for a group's number: 3 is not group 3 but groups 1 and 2."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    for number, cf in enumerate(allcfs.crazyflies):
        cf.setGroupMask(number + 1)
    for number in range(len(allcfs.crazyflies)):
        allcfs.takeoff(targetHeight=0.5 + 0.2 * number, duration=2.0, groupMask=2**number)
        timeHelper.sleep(2.5)
    allcfs.land(targetHeight=0.04, duration=2.5, groupMask=4)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
