"""Modules in the place of `crazyflie_py`, whose Crazyswarm flies the vehicles of a licence.

They are found before any package that is installed. ROS itself is refused: what a program does with rclpy
waits for other processes, and these are not part of a licence.
"""

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType

from q2q_sim.licence.crazyflie_py import ellipsoids
from q2q_sim.licence.crazyflie_py.absent import Absence, AbsentModule
from q2q_sim.licence.crazyflie_py.operator_input import Joystick, KeyPoller
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.crazyflie_py.server_links import ServerLinks
from q2q_sim.licence.crazyflie_py.swarm_calls import CrazyflieServer
from q2q_sim.licence.crazyflie_py.time_helper import TimeHelper
from q2q_sim.licence.crazyflie_py.uav_trajectory import (
    Polynomial,
    Polynomial4D,
    TrajectoryOutput,
    UavTrajectory,
    normalize,
)
from q2q_sim.licence.crazyflie_py.vehicle_calls import CrazyflieCalls
from q2q_sim.licence.program_process.link_host import LinkHost

PACKAGE = "crazyflie_py"
ROS = ("rclpy", "crazyflie_interfaces")
CONNECT_S = 2.0
"""Time in which the server connects and the vehicles pass their checks [s]."""
SETTLE_S = 1.0
"""Longest time that the server goes on sending after the end of the program [s]."""


@dataclass(slots=True)
class SwarmHost:
    """Where the swarms of a program come from."""

    host: LinkHost
    vehicles: Callable[[], tuple[ServedVehicle, ...]]
    links: ServerLinks | None = None

    @property
    def called(self) -> bool:
        """Return whether the program has made a Crazyswarm."""
        return self.links is not None

    def serve(self) -> CrazyflieServer:
        """Return the server, connected to its vehicles."""
        if self.links is not None:
            raise RuntimeError("Crazyswarm() can be called once: rclpy is initialised already")
        vehicles = self.vehicles()
        self.links = ServerLinks(self.host, [one.uri for one in vehicles])
        server = CrazyflieServer(self.links, vehicles)
        time.sleep(CONNECT_S)
        return server

    def settle(self) -> None:
        """Let the server send what waits when the program has ended."""
        if self.links is not None:
            self.links.settle(SETTLE_S)


def install_modules(swarms: SwarmHost) -> None:
    """Put the modules in the place of crazyflie_py for the rest of this process, and refuse ROS."""

    class Crazyswarm(Absence):
        """Swarm of a program."""

        def __init__(self) -> None:
            self.allcfs = swarms.serve()
            self.timeHelper = TimeHelper(self.allcfs.take_reports)
            self.input = Joystick(self.timeHelper)

    package = _module("", Crazyswarm=Crazyswarm)
    package.__path__ = []
    sys.modules[PACKAGE] = package
    for name, module in {
        **CONTENTS,
        "crazyswarm_py": _module("crazyswarm_py", Crazyswarm=Crazyswarm),
    }.items():
        setattr(package, name, module)
        sys.modules[f"{PACKAGE}.{name}"] = module
    for name in [one for one in sys.modules if one.partition(".")[0] in ROS]:
        del sys.modules[name]
    sys.meta_path.insert(0, RosRefused())


def _module(name: str, **contents: object) -> ModuleType:
    """Return a module of the package, the package itself without a name."""
    made = ModuleType(f"{PACKAGE}.{name}".rstrip("."))
    for public, one in contents.items():
        setattr(made, public, one)
    return made


CONTENTS: Mapping[str, ModuleType] = {
    "crazyflie": _module(
        "crazyflie", Crazyflie=CrazyflieCalls, CrazyflieServer=CrazyflieServer, TimeHelper=TimeHelper
    ),
    "genericJoystick": _module("genericJoystick", Joystick=Joystick),
    "keyboard": _module("keyboard", KeyPoller=KeyPoller),
    "uav_trajectory": _module(
        "uav_trajectory",
        Trajectory=UavTrajectory,
        TrajectoryOutput=TrajectoryOutput,
        Polynomial=Polynomial,
        Polynomial4D=Polynomial4D,
        normalize=normalize,
    ),
    "util": ellipsoids,
    "joystick": AbsentModule(f"{PACKAGE}.joystick"),
    "linuxjsdev": AbsentModule(f"{PACKAGE}.linuxjsdev"),
}
"""Modules that do not depend on the flight, by their names in crazyflie_py."""


class RosRefused:
    """Importer that refuses ROS."""

    def find_spec(self, name: str, _: Sequence[str] | None = None, __: ModuleType | None = None) -> None:
        """Raise ImportError for ROS; leave everything else to the other importers."""
        if name.partition(".")[0] in ROS:
            raise ImportError(f"a licence has no {name}: programs command by cflib or {PACKAGE}, not by ROS")

    def invalidate_caches(self) -> None:
        """Do nothing."""
