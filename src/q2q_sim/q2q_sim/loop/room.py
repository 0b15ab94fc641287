"""Simulated room: motion capture, inertial sensors, radio, faults and vehicles, advanced in 10 ms ticks.

    capture()          frame of VICON now, with the truth
    imu()              readings of the inertial sensors now, computed only if they are used or recorded
    advance(command)   send the command of the tick over the radio, advance everything by one tick

Delays: a controller knows only capture stamps, so a late frame and a late command are equivalent. The
camera's latency is therefore added to the radio's, and frames arrive at once. All calls are deterministic:
the same scenario, seed and commands give the same numbers to the last bit. Nothing in the room depends on
`imu`, which is called in every tick or in none: a call draws the noise of one tick.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.stamps import TICK_NS, TICK_S, time_from_stamp
from q2q_model.signals.values import (
    Array,
    Interference,
    MocapFrame,
    Names,
    Rows,
    SwarmCommand,
    SwarmImu,
    SwarmState,
    index_of,
)
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.faults.injection import FaultInjection
from q2q_sim.link.radio import Radio, RadioParams, command_values
from q2q_sim.loop.scenario_air import air_of, ambient_of_air, ambient_of_scenario
from q2q_sim.plant.body.state_row import ACC
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.sensors.imu import Imu
from q2q_sim.sensors.vicon import Flags, Vicon

STEPS = PHYSICS_RATE // 100
"""Physics steps per tick."""
LARGEST = float(np.radians(np.finfo(np.float32).max))
"""Magnitude of a command [N, rad, rad/s] from which a packet does not hold it: float32, angles in degrees."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Frame and truth of one tick."""

    stamp_ns: int
    """True time; it identifies the tick."""
    frame_stamp_ns: int
    """Stamp of the frame; differs from `stamp_ns` only if a fault makes the frame late, repeated or wrong."""
    truth: SwarmState
    truth_interference: Interference
    frame: MocapFrame


class Room:
    """Vehicles, air, cameras and radio of one flight."""

    def __init__(self, scenario: Scenario, seed: int, air: FlownAir | None = None) -> None:
        """Place the vehicles at their first waypoints; `air` replaces the scenario's wake and disturbance.

        Raises:
            ValueError: a negative seed, or an air that cannot be flown in.
        """
        if seed < 0:
            raise ValueError(f"seed = {seed}; must be at least 0")
        self.names: Names = scenario.names
        self.seed = seed
        start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])  # (n, 4)
        n, vehicle = len(start), scenario.vehicle
        flown = air_of(scenario) if air is None else air
        self._swarm = Swarm(scenario.names, vehicle, start, flown, seed)
        self._execute = _execution(scenario, self._swarm)
        self._vicon = Vicon(scenario.vicon, n, TICK_S, seed)
        self._imu = Imu(scenario.imu, n, seed)
        replaced = scenario.air or air is not None
        self._ambient = ambient_of_air(flown, n, seed) if replaced else ambient_of_scenario(scenario, seed)
        self._faults = FaultInjection(scenario.faults, scenario.names, TICK_NS, seed)
        hover = np.where(start[:, 2] > 0.0, vehicle.hover_thrust, 0.0)
        self._radio = Radio(_with_camera_latency(scenario), hover, vehicle, seed)
        self._commanded: Names = ()
        self._command_rows: Rows = np.zeros(0, dtype=np.intp)
        self._valid = np.zeros(n, dtype=np.uint8)  # InterferenceStatus.VALID; ticks share it
        self._exact = np.zeros((n, 3))
        self._valid.flags.writeable = self._exact.flags.writeable = False
        self._tick = 0
        self._seen: Tick | None = None
        self._read: SwarmImu | None = None

    @property
    def tick(self) -> int:
        """Return the number of ticks that have passed."""
        return self._tick

    @property
    def injected(self) -> Flags:
        """Return the effects on each vehicle in the last captured frame: vicon.Injected, (n,)."""
        return self._vicon.injected

    @property
    def locked(self) -> Names:
        """Return the vehicles whose thrust is locked."""
        return tuple(name for name, locked in zip(self.names, self._radio.locked, strict=True) if locked)

    def capture(self) -> Tick:
        """Return frame and truth now; repeated calls in a tick return the same."""
        if self._seen is None:
            stamp_ns = self._tick * TICK_NS
            truth = self._swarm.truth(time_from_stamp(stamp_ns))
            seen = self._vicon.observe(truth)
            delivery = self._faults.deliver(seen, stamp_ns, self._vicon.injected)
            self._seen = Tick(
                stamp_ns=stamp_ns,
                frame_stamp_ns=delivery.stamp_ns,
                truth=truth,
                truth_interference=self._true_downwash(truth),
                frame=delivery.frame,
            )
        return self._seen

    def imu(self) -> SwarmImu:
        """Return the readings of the inertial sensors now; repeated calls in a tick return the same."""
        if self._read is None:
            self._read = self._imu.read(self.capture().truth, self._swarm.state[:, ACC].copy())
        return self._read

    def advance(self, command: SwarmCommand | None) -> None:
        """Advance by one tick; `command` is None if none arrived.

        Raises:
            ValueError: the command is for a vehicle that does not exist, or is not finite in a packet;
                nothing has moved.
        """
        self.capture()  # captured once every tick, so that the noise does not depend on the callers
        now_ns = self._tick * TICK_NS
        if command is not None:
            rows, values = self._rows_of(command), command_values(command)
            if not np.vdot(values, values) < LARGEST**2:
                self._check_finite(command.names, values.T)
            self._radio.send(now_ns, rows, values, self._faults.jammed(now_ns))
        applied = self._radio.applied(now_ns, TICK_NS // STEPS, STEPS)
        self._execute(applied, self._faults.weakened(self._ambient.drive(), now_ns))
        self._tick += 1
        self._seen = self._read = None

    @property
    def swarm(self) -> Swarm:
        """Return the vehicles, for fleets that fly by their own firmware."""
        return self._swarm

    def fly(self, move: Callable[[Array], None]) -> None:
        """Advance by one tick in which `move` steps the swarm with the disturbance's drive (n, 7)."""
        self.capture()
        move(self._faults.weakened(self._ambient.drive(), self._tick * TICK_NS))
        self._tick += 1
        self._seen = self._read = None

    def _rows_of(self, command: SwarmCommand) -> Rows:
        if command.names != self._commanded:
            self._command_rows = self._known_rows(command.names)
            self._commanded = command.names
        return self._command_rows

    def _known_rows(self, names: Names) -> Rows:
        rows = index_of(names, self.names)
        if (rows < 0).any():
            unknown = listed([name for name in names if name not in self.names])
            raise ValueError(f"command for {unknown}: no such vehicle; the vehicles are {listed(self.names)}")
        return rows

    def _check_finite(self, names: Names, values: Array) -> None:
        bad = ~(np.abs(values) < LARGEST).all(axis=1)
        if bad.any():
            who = names[int(np.argmax(bad))]
            given = f"command for {who} is not finite as float32 in degrees: {values[bad][0]}"
            raise ValueError(f"{given}; send finite numbers")

    def _true_downwash(self, truth: SwarmState) -> Interference:
        push = self._ambient.push(self._swarm.downwash())
        return Interference(t=truth.t, names=truth.names, acc=push, std=self._exact, status=self._valid)


def _execution(scenario: Scenario, swarm: Swarm) -> Callable[[Array, Array], None]:
    """Return what advances the swarm by a tick of commands, as Swarm.step."""
    if scenario.attitude == "paper":
        return swarm.step
    from q2q_sim.firmware.commanded_flight import CommandedFlight  # 0.05 s to import

    return CommandedFlight(swarm, scenario.vehicle).step


def _with_camera_latency(scenario: Scenario) -> RadioParams:
    return replace(scenario.radio, latency=scenario.radio.latency + scenario.vicon.latency)
