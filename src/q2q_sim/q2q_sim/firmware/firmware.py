"""Firmware of one vehicle: everything above the controllers, at 100 Hz.

A tick, in the firmware's order (modules/src/stabilizer.c): estimate, high-level commander, commander,
supervisor (25 Hz), override by the supervisor, then the row for the controllers (firmware_tick). Firmware
time is in milliseconds since the start of the room.
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Three
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.commander.commander import Commander, Priority
from q2q_sim.firmware.commander.planner import MOVING, Planner, PlanState
from q2q_sim.firmware.commander.setpoint import STOP, Mode, Setpoint, setpoint_of
from q2q_sim.firmware.controllers.choice import FirmwareController, choose, refusal_of, start_controller
from q2q_sim.firmware.controllers.columns import MOTOR, SETPOINT_WIDTH, Power, setpoint_row
from q2q_sim.firmware.estimator import DT, Estimator
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.firmware_rows import FirmwareRows
from q2q_sim.firmware.motors.airframe import Airframe
from q2q_sim.firmware.motors.battery import VOLT_FULL, Battery
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.firmware.parameters.uploads import Uploads
from q2q_sim.firmware.supervisor.info import supervisor_info
from q2q_sim.firmware.supervisor.supervisor import Supervisor, SupervisorInput
from q2q_sim.plant.body.state_row import POS, ROTORS

TICK_MS = 10
SUPERVISOR_TICKS = 4
"""RATE_SUPERVISOR of the firmware: 25 Hz."""
ZERO_EXPIRES_MS = 500
"""Age at which a vehicle at rest drops a setpoint without thrust, if the build does so."""
SUPPLY_SHARE = 1.0 - 0.99**TICK_MS
"""Weight of a new voltage in the supply after a tick: the low-pass of stabilizer.c takes 1 % each 1 ms."""


@dataclass(slots=True)
class ExternalPose:
    """Last external pose, for logs."""

    pos: Three = (0.0, 0.0, 0.0)
    """[m], world."""
    quat: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """x y z w."""
    at_ms: int = 0


class Firmware:
    """Firmware of one vehicle with all its state."""

    def __init__(self, airframe: Airframe, build: Build, rows: FirmwareRows) -> None:
        self.build = build
        self.rows = rows
        self.uploads = Uploads()
        self.battery = Battery()
        self.now_ms = 0
        self.received = 0
        """Packets since the start of the room."""
        self.parameters = Parameters(airframe, auto_arming=build.auto_arming)
        self._airframe = airframe
        self.boot()

    def boot(self) -> None:
        """Reboot: everything uploaded or set is lost, except the EEPROM."""
        self.parameters.reset()
        for name, value in self.uploads.stored.items():
            self.parameters.set(name, value)
        for deck in self.build.decks:
            self.parameters.set(f"deck.{deck}", 1)
        self.parameters.set("usd.canLog", int("bcUSD" in self.build.decks))
        self.uploads = Uploads(stored=self.uploads.stored)
        self.commander = Commander()
        self.commander.set_ms = self._boot_ms = self.now_ms
        self.planner = Planner()
        self.supervisor = Supervisor(auto_arming=self.build.auto_arming)
        self.external = ExternalPose()
        self.rows.memory[:] = 0.0
        self.thrust_locked = True
        self.requested: Setpoint = STOP
        self.flown: Setpoint = STOP
        self.info = 0
        self._controller = FirmwareController.PID
        self._supply = VOLT_FULL
        self.console = "SYS: Q2Q simulated Crazyflie is up and running!\n"
        self.estimator = Estimator(self.rows.drift)
        self.reset_estimate()

    @property
    def number(self) -> int:
        """Return the last byte of the radio address."""
        return self.build.number

    @property
    def seconds(self) -> float:
        """Return the time [s]."""
        return self.now_ms * 1e-3

    def reset_estimate(self) -> None:
        """Reset the position estimate to kalman.initialX, Y, Z."""
        initial = np.array([float(self.parameters[f"kalman.initial{axis}"]) for axis in "XYZ"])
        self.estimator.forget(initial, self.rows.state[POS])

    def locate(self, measured: Three, quat: tuple[float, float, float, float] | None = None) -> None:
        """Fuse an external position [m], world, and log its attitude."""
        self.external.pos, self.external.at_ms = measured, self.now_ms
        if quat is not None:
            self.external.quat = quat
        if not self.build.positioning_deck:
            self._correct(np.array(measured))

    def accept(self, setpoint: Setpoint) -> None:
        """Accept a client's setpoint and drop the plan being flown."""
        self.requested = setpoint
        if self.commander.offer(setpoint, Priority.CLIENT, self.now_ms):
            self.planner.stop()

    def relax(self) -> None:
        """Let the high-level commander take over from the present position."""
        self._update_planner()
        self.commander.relax()

    def tick(self) -> Array:
        """Run one tick; return the setpoint rows of its first step and of the others, (2, SETPOINT_WIDTH).

        They differ when the supervisor permits flight or stops it: the setpoint of the first step was taken
        before its update.
        """
        self._estimate()
        self._choose_controller()
        self._plan()
        first = self._setpoint
        if self.now_ms // TICK_MS % SUPERVISOR_TICKS == 0:
            self._supervise()
        first, self.flown = (self.supervisor.overridden(one) for one in (first, self._setpoint))
        power = self._power()
        self.now_ms += TICK_MS
        rows = np.empty((2, SETPOINT_WIDTH))
        rows[:] = setpoint_row(self.flown, power)
        if first is not self.flown:
            rows[0] = setpoint_row(first, power)
        return rows

    @property
    def idle_pwm(self) -> float:
        """Return the smallest duty of a running motor [PWM]."""
        return 0.0 if self.build.auto_arming else float(self.parameters["powerDist.idleThrust"])

    @property
    def _motors_running(self) -> bool:
        return bool((self.rows.memory[MOTOR : MOTOR + 4] > self.idle_pwm).any())

    @property
    def _setpoint(self) -> Setpoint:
        return self.commander.setpoint if self.supervisor.may_fly else STOP

    def _power(self) -> Power:
        """Drain the battery by one tick; return the motor limits set by it and the supervisor."""
        hovers = float(self.rows.state[ROTORS].sum()) / (self._airframe.mass * GRAVITY)
        self.battery.drain(hovers, DT, float(self.parameters["pm.lowVoltage"]))
        volt = self.battery.volt
        self._supply += SUPPLY_SHARE * (volt - self._supply)
        return Power(self.supervisor.motors_may_run, self.idle_pwm, self._supply, volt)

    def _choose_controller(self) -> None:
        asked = int(self.parameters["stabilizer.controller"])
        if asked == self._controller:
            return
        flown = choose(asked, self._controller)
        self.console += refusal_of(asked, flown)
        if asked <= max(FirmwareController):
            start_controller(flown, self.rows.memory)
        self._controller = flown
        self.parameters.set("stabilizer.controller", int(flown))

    def _estimate(self) -> None:
        if self.parameters.flag("kalman.resetEstimation"):
            self.reset_estimate()
            self.parameters.set("kalman.resetEstimation", 0)
        xy, z = float(self.parameters["kalman.pNAcc_xy"]), float(self.parameters["kalman.pNAcc_z"])
        self.estimator.predict(np.array([xy, xy, z]))
        if self.build.positioning_deck:
            self._correct(self.rows.state[POS])
        elif self.build.flow_deck:
            self.estimator.correct_by_flow(self.rows.state)

    def _correct(self, measured: Array) -> None:
        std = float(self.parameters["locSrv.extPosStdDev"])
        self.estimator.correct(measured, self.rows.state[POS], std)

    def _expire(self) -> None:
        """Let the high-level commander take over from a client that has left the motors off."""
        one, age_ms = self.commander.setpoint, self.now_ms - self.commander.set_ms
        off = one.z == Mode.DISABLE and one.thrust_pwm == 0 and not self._motors_running
        if off and age_ms >= ZERO_EXPIRES_MS and self.commander.priority == Priority.CLIENT:
            self.relax()

    def _plan(self) -> None:
        if self.build.zero_expires:
            self._expire()
        if not self.supervisor.may_fly:
            if self.planner.state in MOVING:
                self.planner.stop()
            self._update_planner()
            return
        goal = self.planner.goal(self.seconds)
        if goal is None:
            self._update_planner()
        if self.planner.state != PlanState.DISABLED:
            setpoint = STOP if goal is None else setpoint_of(goal)
            self.commander.offer(setpoint, Priority.HIGH_LEVEL, self.now_ms)

    def _update_planner(self) -> None:
        self.planner.set_state(self.rows.pos, self.rows.vel, math.radians(self.rows.attitude_deg[2]))

    def _supervise(self) -> None:
        x, y, z = self.rows.specific_force_g.tolist()
        look = SupervisorInput(
            now_ms=self.now_ms,
            acc=(x, y, z),
            setpoint_ms=self.commander.set_ms if self.supervisor.may_fly else self._boot_ms,
            motors_running=self._motors_running,
        )
        self.console += self.supervisor.update(look, self.parameters)
        self.info = supervisor_info(self.supervisor, self.planner, self.seconds)
