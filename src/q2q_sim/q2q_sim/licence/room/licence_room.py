"""Room of a licence: vehicles that fly by their own firmware, with motion capture, one fault and a log.

Motion capture sends every vehicle its position 100 times per second, as a Crazyswarm2 server does, so that
the program need not. One packet takes PACKET_S. A vehicle without link flies on by its firmware.
"""

import math
from collections import deque
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from q2q_model.signals.stamps import TICK_NS, TICK_S
from q2q_model.signals.values import Array, Names, Three
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.packets.packet import MalformedError, packet_of
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.faults.injection import FaultInjection
from q2q_sim.firmware.commander.setpoint import Mode
from q2q_sim.firmware.controllers.columns import MOTOR
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import ClientCommand
from q2q_sim.licence.client_commands.packet_command import client_command, malformed_command
from q2q_sim.licence.room.licence_log import LicenceLog, ProgramEnd
from q2q_sim.licence.room.trials import CHARGE, GAP_S, PUSH, LicenceTrial, TrialKind
from q2q_sim.loop.room import Room
from q2q_sim.plant.body.state_row import POS, QUAT, ROTORS, VEL, R
from q2q_sim.scenarios.room_profiles import CAPTURE
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.sensors.range_finder import RoomBox

PACKET_S = 0.001
"""Time that one packet takes: a Crazyradio sends some 1000 per second [s]."""
NOTICED_S = 1.0
"""Time after which a radio reports a lost link [s]."""
DECKS = ("bcFlow2", "bcLighthouse4", "bcMultiranger", "bcZRanger2")
"""Decks reported to programs that ask for them."""
LONGEST_S = 3600.0


@dataclass(frozen=True, slots=True)
class LicenceParams:
    """Room and vehicles of a licence."""

    starts: tuple[Three, ...]
    """x, y [m], yaw [rad] of every vehicle on the floor."""
    air: str = "room"
    seed: int = 0
    arming: bool = False
    """The vehicles do not arm themselves."""
    room: RoomBox = field(default_factory=RoomBox)
    """What their range finders see."""

    @property
    def scenario(self) -> Scenario:
        """Return the room as a scenario without paths."""
        return Scenario(
            name="licence",
            description="a program's flight",
            duration=LONGEST_S,
            vehicle=CRAZYFLIE_2_0,
            waypoints=tuple(
                VehicleWaypoints(f"cf{k + 1}", tuple(Waypoint(t, (x, y, 0.0), yaw) for t in (0.0, LONGEST_S)))
                for k, (x, y, yaw) in enumerate(self.starts)
            ),
            air=self.air,
        )


@dataclass(slots=True, eq=False)
class OpenLink:
    """Link of a program to a vehicle."""

    vehicle: int
    inbox: deque[bytes] = field(default_factory=deque)
    """Packets for the program."""


class Sender(NamedTuple):
    """Place in the program that sends a packet."""

    line: int
    closing: bool
    """Whether it closes the link."""


@dataclass(slots=True)
class _Columns:
    """Rows of the log, one for each tick."""

    state: list[Array] = field(default_factory=list)
    """(n, STATE_WIDTH)"""
    running: list[list[bool]] = field(default_factory=list)
    """Motors run, (n,)."""
    supervisor: list[list[int]] = field(default_factory=list)
    """State of the supervisor, (n,)."""
    age_ms: list[list[int]] = field(default_factory=list)
    """Age of the setpoint [ms], (n,)."""


class LicenceRoom:
    """Vehicles of one flight of a program."""

    def __init__(self, params: LicenceParams, trial: LicenceTrial) -> None:
        scenario = params.scenario
        names = scenario.names
        self.trial = trial
        self.commands: list[ClientCommand] = []
        self.opened: list[int] = []
        self._room = Room(_with_faults(scenario, trial), params.seed)
        self._names = names
        self._rotors = FaultInjection(trial.rotor_faults(names), names, TICK_NS, params.seed)
        build = Build(auto_arming=not params.arming, positioning_deck=False, decks=DECKS, room=params.room)
        self._fleet = Fleet(self._room.swarm, scenario.vehicle, build)
        self._columns = _Columns()
        for vehicle in self._fleet.vehicles:
            vehicle.firmware.supervisor.wait_on_floor()
        if trial.kind == TrialKind.BATTERY:
            self._fleet.vehicles[trial.vehicle].firmware.battery.charge = CHARGE

    @property
    def t(self) -> float:
        """Return the time of the last tick [s]."""
        return self._room.tick * TICK_S

    def fly(self) -> None:
        """Advance by one tick: poses to the vehicles, flight, packets to the program, log."""
        self._locate()
        if self.trial.kind == TrialKind.UNARMED:
            self._fleet.vehicles[self.trial.vehicle].firmware.supervisor.state = State.CHECKS_NOT_PASSED
        self._room.fly(self._move)
        for one in self._fleet.outgoing():
            if isinstance(one.client, OpenLink) and self.silent_until(one.vehicle, self.t) <= self.t:
                one.client.inbox.append(one.datagram)
        self._record()

    def deliver(self, link: OpenLink, datagram: bytes, t: float, sender: Sender) -> None:
        """Hand a packet of the program to its vehicle, with the answers to the program.

        Args:
            link: of the program.
            datagram: the packet.
            t: time [s].
            sender: where the program sends it.
        """
        vehicle = self._fleet.vehicles[link.vehicle]
        refusals = vehicle.refusals.count
        answers = vehicle.handle(datagram, link)
        try:
            packet = packet_of(datagram)
            if vehicle.refusals.count > refusals:
                asked = malformed_command(packet)
            else:
                asked = client_command(packet, [packet_of(one) for one in answers], vehicle.firmware)
        except MalformedError:
            return
        if asked is not None:
            self.commands.append(ClientCommand(t, link.vehicle, asked, *sender))
        link.inbox.extend(answers)

    def keep_alive(self, link: OpenLink) -> None:
        """Poll a vehicle as its radio does."""
        self._fleet.vehicles[link.vehicle].handle(ECHO_REQUEST, link)

    def silent_until(self, vehicle: int, t: float) -> float:
        """Return the time [s] from which packets to and from a vehicle pass again; t if they do."""
        trial = self.trial
        if vehicle != trial.vehicle or t < trial.start:
            return t
        if trial.kind == TrialKind.LOST:
            return math.inf
        return max(t, trial.start + GAP_S) if trial.kind == TrialKind.GAP else t

    def is_noticed(self, vehicle: int, t: float) -> bool:
        """Return whether a radio reports the link to a vehicle as lost at t [s]."""
        return self.silent_until(vehicle, t) == math.inf and t >= self.trial.start + NOTICED_S

    def is_active(self) -> bool:
        """Return whether a vehicle is above the floor, moves, or may run its motors."""
        state = self._room.swarm.state
        moves = (state[:, POS][:, 2] > 0.0).any() or (np.abs(state[:, VEL]) > 0.0).any()
        return bool(moves) or any(may_run_motors(vehicle.firmware) for vehicle in self._fleet.vehicles)

    def log(self, uris: Names, names: Names, end: ProgramEnd, output: str) -> LicenceLog:
        """Return the flight so far, of vehicles with these URIs and names."""
        state = np.stack(self._columns.state)  # (T, n, STATE_WIDTH)
        weight = CRAZYFLIE_2_0.mass * GRAVITY
        return LicenceLog(
            uris=uris,
            names=names,
            trial=self.trial,
            t=np.asarray(TICK_S * np.arange(1, len(state) + 1), dtype=np.float64),
            pos=state[..., POS],
            vel=state[..., VEL],
            quat=state[..., QUAT],
            yaw_rate=state[..., R],
            thrust=state[..., ROTORS].sum(axis=-1) / weight,
            running=np.array(self._columns.running),
            state=np.array(self._columns.supervisor),
            age=1e-3 * np.array(self._columns.age_ms),
            commands=tuple(self.commands),
            opened=tuple(sorted(set(self.opened))),
            end=end,
            output=output,
        )

    def _locate(self) -> None:
        frame = self._room.capture().frame
        for name, pos in zip(frame.names, frame.pos, strict=True):
            if np.isfinite(pos).all():
                x, y, z = pos.tolist()
                self._fleet.vehicles[self._names.index(name)].firmware.locate((x, y, z))

    def _move(self, drive: Array) -> None:
        drive = self._rotors.weakened(drive.copy(), self._room.tick * TICK_NS)
        if self.trial.pushed(self.t):
            drive[self.trial.vehicle, 2] -= PUSH
        self._fleet.fly(drive)

    def _record(self) -> None:
        self._columns.state.append(self._room.swarm.state.copy())
        every = [vehicle.firmware for vehicle in self._fleet.vehicles]
        self._columns.running.append([may_run_motors(one) for one in every])
        self._columns.supervisor.append([int(one.supervisor.state) for one in every])
        self._columns.age_ms.append([one.now_ms - one.commander.set_ms for one in every])


def may_run_motors(one: Firmware) -> bool:
    """Return whether a motor runs, or a controller of the height may run them.

    Mellinger's controller asks for no thrust for a tenth of a second when its position jumps upwards, from
    which it recovers; that of the PID has a least thrust.
    """
    controlled = one.flown.z != Mode.DISABLE and one.supervisor.motors_may_run
    return controlled or bool((one.rows.memory[MOTOR : MOTOR + 4] > one.idle_pwm).any())


def _with_faults(scenario: Scenario, trial: LicenceTrial) -> Scenario:
    """Return a scenario with noisy motion capture and the faults of a trial."""
    seen = replace(CAPTURE.vicon, outlier_rate=0.0, dropout_rate=0.0)
    return replace(scenario, vicon=seen, faults=trial.capture_faults(scenario.names))
