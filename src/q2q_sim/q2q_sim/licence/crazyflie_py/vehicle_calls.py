"""Class Crazyflie: commands to one vehicle, and what it reports."""

from typing import Protocol

import numpy as np

from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.licence.crazyflie_py import server_packets
from q2q_sim.licence.crazyflie_py.absent import Absence
from q2q_sim.licence.crazyflie_py.message_fields import (
    NUMBERS,
    coefficients,
    flag,
    real,
    seconds,
    three,
    value_to_send,
    whole,
)
from q2q_sim.licence.crazyflie_py.reports import Pose, StatusReport, report_in_packet
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.crazyflie_py.server_links import ServerLinks
from q2q_sim.licence.crazyflie_py.uav_trajectory import UavTrajectory, pieces_of
from q2q_sim.licence.program_process.patched_time import EPOCH

MASK, BYTE, MOST = 255, 255, 2**32 - 1
COEFFICIENTS = 8


class Points(Protocol):
    """Anything with coordinates: a list, a tuple, an array."""

    def __getitem__(self, index: int, /) -> object:
        """Return a coordinate."""
        ...


class CrazyflieCalls(Absence):
    """One vehicle: crazyflie_py's class Crazyflie."""

    public_name = "Crazyflie"

    def __init__(self, node: object, links: ServerLinks, number: int, vehicle: ServedVehicle) -> None:
        self.node = node
        self.prefix = f"/{vehicle.name}"
        self.uri = vehicle.uri
        self.initialPosition = np.array(vehicle.initial)
        self.paramTypeDict = NUMBERS
        self.status: StatusReport = {}
        self.poseStamped: dict[str, object] = {}
        self.pose: dict[str, object] = {}
        self.position = [0.0, 0.0, 0.0]
        self.parameters: dict[str, float] = {}
        self._links, self._number = links, number

    def setGroupMask(self, groupMask: int) -> None:
        """Set the groups of the vehicle, one bit for each."""
        self.setParam("hlCommander.groupmask", groupMask)

    def emergency(self) -> None:
        """Stop the motors until a reboot."""
        self._links.send(self._number, server_packets.emergency())

    def takeoff(self, targetHeight: float, duration: float, groupMask: int = 0) -> None:
        """Take off to a height [m] in a duration [s]."""
        self._vertical(server_packets.TAKE_OFF, targetHeight, duration, groupMask)

    def land(self, targetHeight: float, duration: float, groupMask: int = 0) -> None:
        """Land at a height [m] in a duration [s]."""
        self._vertical(server_packets.LAND, targetHeight, duration, groupMask)

    def goTo(
        self, goal: Points, yaw: float, duration: float, relative: bool = False, groupMask: int = 0
    ) -> None:
        """Go to a position [m] and yaw [rad] in a duration [s]."""
        packet = server_packets.go_to(
            three(goal, "goTo: goal"),
            float(yaw),
            seconds(duration, "goTo: duration"),
            relative=flag(relative, "goTo: relative"),
            mask=whole(groupMask, "goTo: groupMask", MASK),
        )
        self._links.send(self._number, packet)

    def uploadTrajectory(self, trajectoryId: int, pieceOffset: int, trajectory: UavTrajectory) -> None:
        """Upload a trajectory, behind `pieceOffset` pieces of others; returns when it has arrived."""
        pieces = []
        for one in pieces_of(trajectory):
            named = {"px": one.px, "py": one.py, "pz": one.pz, "pyaw": one.pyaw}
            axes = [coefficients(axis.p, f"uploadTrajectory: {name}.p") for name, axis in named.items()]
            if any(axis.shape != (COEFFICIENTS,) for axis in axes):
                print(f"[{self.prefix[1:]}] Wrong number of pieces!")
                return
            pieces.append((seconds(one.duration, "uploadTrajectory: duration"), np.stack(axes)))
        number = whole(trajectoryId, "uploadTrajectory: trajectoryId", BYTE)
        offset = whole(pieceOffset, "uploadTrajectory: pieceOffset", MOST)
        for packet in server_packets.upload(number, offset, pieces):
            self._links.ask(self._number, packet)

    def startTrajectory(
        self,
        trajectoryId: int,
        timescale: float = 1.0,
        reverse: bool = False,
        relative: bool = True,
        groupMask: int = 0,
    ) -> None:
        """Fly an uploaded trajectory, at `timescale` times its durations."""
        packet = start_packet(trajectoryId, timescale, reverse, groupMask, relative=relative)
        self._links.send(self._number, packet)

    def notifySetpointsStop(self, remainValidMillisecs: int = 100, groupMask: int = 0) -> None:
        """Let the high-level commander take over from streamed setpoints."""
        whole(groupMask, "notifySetpointsStop: groupMask", MASK)  # the server does not send it
        remain = whole(remainValidMillisecs, "notifySetpointsStop: remainValidMillisecs", MOST)
        self._links.send(self._number, server_packets.setpoints_stop(remain))

    def arm(self, arm: bool = True) -> None:
        """Arm or disarm."""
        self._links.send(self._number, server_packets.arming(arm=flag(arm, "arm")))

    def getParam(self, name: str) -> float:
        """Return a parameter as set by setParam; not a number before, as the server reads none by itself."""
        if name not in NUMBERS:
            print(f"getParam: {name} is not a parameter of the emulated firmware (docs/licence.md, Limits)")
        elif name not in self.parameters:
            print(f"getParam: {name} is not set yet: server.yaml has query_all_values_on_connect: False")
        return self.parameters.get(name, float("nan"))

    def setParam(self, name: str, value: float) -> None:
        """Set a parameter."""
        asked = value_to_send(name, value)
        if asked is None:
            return
        self.parameters[name] = asked
        packet = server_packets.parameter_write(NUMBERS[name], TABLE[NUMBERS[name]], asked)
        self._links.send(self._number, packet)

    def cmdFullState(self, pos: Points, vel: Points, acc: Points, yaw: float, omega: Points) -> None:
        """Send a full-state setpoint: [m], [m/s], [m/s^2], world; [rad]; [rad/s], body."""
        self._links.send(self._number, full_state_packet(pos, vel, acc, yaw, omega))

    def cmdPosition(self, pos: Points, yaw: float = 0.0) -> None:
        """Send a position setpoint [m]; the yaw reaches the firmware as degrees."""
        packet = server_packets.position(three(pos, "cmdPosition: pos"), real(yaw, "cmdPosition: yaw"))
        self._links.send(self._number, packet)

    def cmdHover(self, vx: float, vy: float, yaw_rate: float, z_distance: float) -> None:
        """Send a hover setpoint: forward, left [m/s], yaw rate [rad/s], height [m]."""
        packet = server_packets.hover(
            real(vx, "cmdHover: vx"),
            real(vy, "cmdHover: vy"),
            real(yaw_rate, "cmdHover: yaw_rate"),
            real(z_distance, "cmdHover: z_distance"),
        )
        self._links.send(self._number, packet)

    def get_status(self) -> StatusReport:
        """Return the last status; empty before the first."""
        return self.status

    def get_pose(self) -> dict[str, object]:
        """Return the last pose; empty before the first."""
        return self.pose

    def get_position(self) -> list[float]:
        """Return the last position [m]; zero before the first."""
        return self.position

    def take_reports(self) -> None:
        """Take what the vehicle has reported; crazyflie_py does so while the program sleeps."""
        for datagram in self._links.received(self._number):
            report = report_in_packet(datagram)
            if isinstance(report, Pose):
                self.position = list(report.position)
                self.pose = {"position": report.position, "orientation": report.orientation}
                self.poseStamped = {**self._stamp("world"), "pose": report}
            elif report is not None:
                self.status = {**self._stamp(self.prefix[1:]), **report}

    def _stamp(self, frame: str) -> dict[str, str | float]:
        whole_s, rest = divmod(EPOCH + self._links.now, 1.0)
        return {"id": frame, "timestamp_sec": int(whole_s), "timestamp_nsec": int(1e9 * rest)}

    def _vertical(self, command: int, height: float, duration: float, mask: int) -> None:
        self._links.send(self._number, vertical_packet(command, height, duration, mask))


def vertical_packet(command: int, height: float, duration: float, mask: int) -> Packet:
    """Return the packet of a take-off or landing by a program."""
    call = "takeoff" if command == server_packets.TAKE_OFF else "land"
    return server_packets.vertical(
        command,
        real(height, f"{call}: targetHeight"),
        seconds(duration, f"{call}: duration"),
        whole(mask, f"{call}: groupMask", MASK),
    )


def full_state_packet(pos: Points, vel: Points, acc: Points, yaw: float, omega: Points) -> Packet:
    """Return the packet of a full-state setpoint by a program."""
    return server_packets.full_state(
        three(pos, "cmdFullState: pos"),
        three(vel, "cmdFullState: vel"),
        three(acc, "cmdFullState: acc"),
        float(yaw),
        three(omega, "cmdFullState: omega"),
    )


def start_packet(number: int, timescale: float, reverse: bool, mask: int, *, relative: bool) -> Packet:
    """Return the packet of the start of a trajectory by a program."""
    return server_packets.start(
        whole(number, "startTrajectory: trajectoryId", BYTE),
        real(timescale, "startTrajectory: timescale"),
        backwards=flag(reverse, "startTrajectory: reverse"),
        relative=flag(relative, "startTrajectory: relative"),
        mask=whole(mask, "startTrajectory: groupMask", MASK),
    )
