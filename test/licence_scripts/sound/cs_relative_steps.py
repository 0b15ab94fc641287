"""Two vehicles fly a square by relative steps, one after the other."""

from crazyflie_py import Crazyswarm

STEPS = ((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5))


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    allcfs = swarm.allcfs

    allcfs.takeoff(targetHeight=0.8, duration=2.0)
    timeHelper.sleep(2.5)
    for cf in allcfs.crazyflies:
        for x, y in STEPS:
            cf.goTo([x, y, 0.0], 0.0, 2.0, relative=True)
            timeHelper.sleep(2.2)
    allcfs.goTo([0.0, 0.0, 0.4], 0.0, 2.0)
    timeHelper.sleep(2.2)
    allcfs.land(targetHeight=0.04, duration=2.5)
    timeHelper.sleep(3.0)


if __name__ == "__main__":
    main()
