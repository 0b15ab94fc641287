"""Supervisor of one vehicle, at 25 Hz: arming, watchdogs, emergency stop, tumbling.

Source: firmware: modules/src/supervisor.c.

| constant | meaning |
|---|---|
| LEVEL_MS | setpoint older: level out, keep height or thrust (q2q_model.vehicle.setpoint_watchdog) |
| CUT_MS | older: motors off, locked until a reboot (the same) |
| FED_MS | emergency stop watchdog, once started, to be fed every 1 s (..._WATCHDOG_TIMEOUT) |
| FLYING_MS | a motor has run within 2 s: flying (IS_FLYING_HYSTERESIS_THRESHOLD) |
| TILT_, OVER_ | 60 deg (acc z below 0.5 g) for 1 s, or upside down for 0.1 s: tumbled (platform_defaults.h) |
"""

from dataclasses import dataclass, replace

from q2q_model.signals.values import Three
from q2q_model.vehicle.setpoint_watchdog import CUT_AFTER_S, LEVEL_AFTER_S
from q2q_sim.firmware.commander.setpoint import STOP, Mode, Setpoint
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.firmware.supervisor.rules import (
    MAY_FLY,
    MOTORS_MAY_RUN,
    STAYS_ARMED,
    Condition,
    State,
    next_state,
)

LEVEL_MS, CUT_MS = round(LEVEL_AFTER_S * 1e3), round(CUT_AFTER_S * 1e3)
FED_MS, FLYING_MS = 1000, 2000
TILT_ACC, TILT_MS, OVER_ACC, OVER_MS = 0.5, 1000, -0.2, 100
"""[g], [ms]."""
FREE_FALL_ACC = 0.1
"""Specific force below which a vehicle falls freely, which is not tumbling [g]."""
WORDS = {
    State.LOCKED: "SUP: Locked, reboot required\n",
    State.CRASHED: "SUP: Crashed, recovery required\n",
    State.FREE_FALL: "SUP: free falling!\n",
}
"""Console message on entering a state."""


@dataclass(frozen=True, slots=True)
class SupervisorInput:
    """Inputs of one update of the supervisor."""

    now_ms: int
    acc: Three
    """Specific force, body [g]."""
    setpoint_ms: int
    """Time of the setpoint [ms]; the start of the firmware if setpoints are not flown."""
    motors_running: bool
    """A duty is above the idle thrust."""


class Supervisor:
    """Supervisor with its state and the memory of arming, thrust and tumbling."""

    def __init__(self, *, auto_arming: bool) -> None:
        self.state = State.NOT_INITIALIZED
        self.auto_arming = auto_arming
        self.armed = self.crashed = self.tumbled = self._stopped = False
        self._fed_ms: int | None = None
        self._thrust_ms: int | None = None
        self._tilt_ms: int | None = None
        self._entered_ms = 0

    @property
    def may_fly(self) -> bool:
        """Return whether setpoints are flown."""
        return self.state in MAY_FLY

    @property
    def motors_may_run(self) -> bool:
        """Return whether the motors may run."""
        return self.state in MOTORS_MAY_RUN

    @property
    def flying(self) -> bool:
        """Return whether the vehicle considers itself in the air."""
        return self.state in {State.FLYING, State.LEVEL_OUT}

    def wait_on_floor(self) -> None:
        """Take the state of a vehicle that has been on for a while: armed if it arms itself."""
        self.armed = self.auto_arming
        self.state = State.READY_TO_FLY if self.auto_arming else State.CHECKS_PASSED

    def stop(self) -> None:
        """Stop the motors until a reboot: emergency stop."""
        self._stopped = True

    def feed(self, now_ms: int) -> None:
        """Start or feed the emergency stop watchdog."""
        self._fed_ms = now_ms

    def is_starved(self, now_ms: int) -> bool:
        """Return whether the emergency stop watchdog was started, and not fed in time."""
        return self._fed_ms is not None and now_ms >= self._fed_ms + FED_MS

    def request_arming(self, *, arm: bool) -> bool:
        """Arm or disarm; return whether it was permitted."""
        if arm and not self.armed and self.state != State.CHECKS_PASSED:
            return False
        self.armed = arm
        return True

    def recover(self) -> bool:
        """Clear a crash if the vehicle is upright; return whether it has recovered."""
        if self.crashed and self.tumbled:
            return False
        self.crashed = False
        return True

    def update(self, look: SupervisorInput, parameters: Parameters) -> str:
        """Update once; return a console message, usually empty."""
        state = next_state(self.state, self._conditions(look, parameters))
        if state == self.state:
            return ""
        self.state, self._entered_ms = state, look.now_ms
        self.crashed = self.crashed or state == State.CRASHED
        if state not in STAYS_ARMED:
            self.armed = False
        if self.auto_arming and state == State.CHECKS_PASSED:
            self.armed = True
        return WORDS.get(state, "")

    def overridden(self, setpoint: Setpoint) -> Setpoint:
        """Return the setpoint as the present state permits it.

        Levelling out keeps the rates of roll and pitch: Mellinger's controller continues to follow them.
        """
        if self.state == State.LEVEL_OUT:
            return replace(
                setpoint,
                x=Mode.DISABLE,
                y=Mode.DISABLE,
                roll=Mode.ABS,
                pitch=Mode.ABS,
                yaw=Mode.VELOCITY,
                attitude_deg=(0.0, 0.0, setpoint.attitude_deg[2]),
                rate_deg=(*setpoint.rate_deg[:2], 0.0),
            )
        return setpoint if self.motors_may_run else STOP

    def _conditions(self, look: SupervisorInput, parameters: Parameters) -> Condition:
        age = look.now_ms - look.setpoint_ms
        starved = self.is_starved(look.now_ms)
        self.tumbled = self._update_tumbled(look) and parameters.flag("supervisor.tmblChckEn")
        flags = {
            Condition.ARMED: self.armed,
            Condition.IS_FLYING: self._update_thrust(look),
            Condition.TUMBLED: self.tumbled,
            Condition.SETPOINT_OLD: age > LEVEL_MS,
            Condition.SETPOINT_DEAD: age > CUT_MS,
            Condition.EMERGENCY_STOP: self._stopped or starved or parameters.flag("stabilizer.stop"),
            Condition.CRASHED: self.crashed,
            Condition.PREFLIGHT_TIMEOUT: self._waits(State.READY_TO_FLY, "prefltTimeout", look, parameters),
            Condition.LANDING_TIMEOUT: self._waits(State.LANDED, "landedTimeout", look, parameters),
        }
        now = Condition.NONE
        for condition, holds in flags.items():
            now |= condition if holds else Condition.NONE
        return now

    def _waits(self, state: State, name: str, look: SupervisorInput, parameters: Parameters) -> bool:
        """Return whether the vehicle has been in a state for longer than a parameter [ms] allows."""
        waited = look.now_ms - self._entered_ms
        return self.state == state and waited > parameters[f"supervisor.{name}"]

    def _update_thrust(self, look: SupervisorInput) -> bool:
        if look.motors_running:
            self._thrust_ms = look.now_ms
        return self._thrust_ms is not None and look.now_ms - self._thrust_ms < FLYING_MS

    def _update_tumbled(self, look: SupervisorInput) -> bool:
        falling = max(abs(axis) for axis in look.acc) < FREE_FALL_ACC
        if falling or look.acc[2] >= TILT_ACC:
            self._tilt_ms = None
        if look.acc[2] >= TILT_ACC:
            return False
        self._tilt_ms = look.now_ms if self._tilt_ms is None else self._tilt_ms
        tilted = look.now_ms - self._tilt_ms
        return tilted > TILT_MS or (look.acc[2] < OVER_ACC and tilted > OVER_MS)
