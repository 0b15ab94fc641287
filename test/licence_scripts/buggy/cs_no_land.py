"""Bug: the program ends without a landing; Crazyswarm2's server does not land it."""

from crazyflie_py import Crazyswarm


def main() -> None:
    """Fly."""
    swarm = Crazyswarm()
    timeHelper = swarm.timeHelper
    cf = swarm.allcfs.crazyflies[0]

    cf.takeoff(targetHeight=1.0, duration=2.0)
    timeHelper.sleep(3.0)
    cf.goTo([0.5, 0.0, 1.0], 0.0, 2.0)
    timeHelper.sleep(2.5)


if __name__ == "__main__":
    main()
