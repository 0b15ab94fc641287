"""Class CrazyflieServer: all vehicles, and commands to all at once."""

from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.licence.crazyflie_py import server_packets
from q2q_sim.licence.crazyflie_py.absent import Absence
from q2q_sim.licence.crazyflie_py.connection import connect
from q2q_sim.licence.crazyflie_py.message_fields import (
    NUMBERS,
    flag,
    real,
    seconds,
    three,
    value_to_send,
    whole,
)
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.crazyflie_py.server_links import ServerLinks
from q2q_sim.licence.crazyflie_py.vehicle_calls import (
    MASK,
    CrazyflieCalls,
    Points,
    full_state_packet,
    start_packet,
    vertical_packet,
)


class CrazyflieServer(Absence):
    """All vehicles of the server."""

    def __init__(self, links: ServerLinks, vehicles: tuple[ServedVehicle, ...]) -> None:
        self._links = links
        self.paramTypeDict = NUMBERS
        self.crazyflies = [CrazyflieCalls(self, links, number, one) for number, one in enumerate(vehicles)]
        self.crazyfliesByName = {one.prefix[1:]: one for one in self.crazyflies}
        self.crazyfliesById = {int(one.uri[-2:], 16): one for one in self.crazyflies}
        for number, served in enumerate(vehicles):
            connect(links, number, served)

    def emergency(self) -> None:
        """Stop the motors of all until a reboot."""
        self._links.broadcast(server_packets.emergency())

    def takeoff(self, targetHeight: float, duration: float, groupMask: int = 0) -> None:
        """Take off to a height [m] in a duration [s]."""
        self._links.broadcast(vertical_packet(server_packets.TAKE_OFF, targetHeight, duration, groupMask))

    def land(self, targetHeight: float, duration: float, groupMask: int = 0) -> None:
        """Land at a height [m] in a duration [s]."""
        self._links.broadcast(vertical_packet(server_packets.LAND, targetHeight, duration, groupMask))

    def goTo(self, goal: Points, yaw: float, duration: float, groupMask: int = 0) -> None:
        """Go by an offset [m] and yaw [rad] in a duration [s]."""
        packet = server_packets.go_to(
            three(goal, "goTo: goal"),
            real(yaw, "goTo: yaw"),
            seconds(duration, "goTo: duration"),
            relative=True,
            mask=whole(groupMask, "goTo: groupMask", MASK),
        )
        self._links.broadcast(packet)

    def startTrajectory(
        self,
        trajectoryId: int,
        timescale: float = 1.0,
        reverse: bool = False,
        relative: bool = True,
        groupMask: int = 0,
    ) -> None:
        """Fly an uploaded trajectory from the present position: broadcasts are always relative."""
        flag(relative, "startTrajectory: relative")
        self._links.broadcast(start_packet(trajectoryId, timescale, reverse, groupMask, relative=True))

    def arm(self, arm: bool = True) -> None:
        """Arm or disarm all."""
        self._links.broadcast(server_packets.arming(arm=flag(arm, "arm")))

    def setParam(self, name: str, value: float) -> None:
        """Set a parameter of all."""
        asked = value_to_send(name, value)
        if asked is not None:
            self._links.broadcast(server_packets.parameter_write_by_name(TABLE[NUMBERS[name]], asked))

    def cmdFullState(self, pos: Points, vel: Points, acc: Points, yaw: float, omega: Points) -> None:
        """Send one full-state setpoint to all: [m], [m/s], [m/s^2], world; [rad]; [rad/s], body."""
        self._links.broadcast(full_state_packet(pos, vel, acc, yaw, omega))

    def take_reports(self) -> None:
        """Take what the vehicles have reported."""
        for one in self.crazyflies:
            one.take_reports()
