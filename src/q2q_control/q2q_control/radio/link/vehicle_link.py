"""Interface of the link to one vehicle, and sending through cflib's own objects.

`CflibSender` holds the parts of cflib's Crazyflie that encode and send: those of a real link
(q2q_control.radio.link.cflib_link) or, in tests, of one whose packets go to a simulated vehicle.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from q2q_control.radio.link.setpoints import FullState, RpytSetpoint
from q2q_model.vehicle.hover_thrust import OwnHover


@dataclass(frozen=True, slots=True)
class LinkHealth:
    """Health of a link and of its vehicle."""

    connected: bool
    volt: float = math.nan
    """Battery [V]; NaN while unknown."""
    quality: float = math.nan
    """Share of packets that are acknowledged; NaN while unknown."""
    armed: bool = False
    """Armed, and ready to fly."""
    locked: bool = False
    """The vehicle is locked after an emergency stop and must be restarted."""
    flying: bool | None = None
    """The vehicle flies, by its supervisor; None while unknown."""
    onboard: tuple[float, float, float] | None = None
    """Onboard position estimate [m], world; None before the first one."""
    own_hover: OwnHover | None = None
    """Hover thrust by the vehicle's own parameters; None while unknown."""
    wrong: str = ""
    """First error of the vehicle's parameters; empty if there is none."""


@dataclass(frozen=True, slots=True)
class OnboardPose:
    """Pose estimated on board a vehicle."""

    pos: tuple[float, float, float]
    """[m], world."""
    quat: tuple[float, ...]
    """x y z w, body to world."""


class VehicleLink(Protocol):
    """Link to one vehicle."""

    def health(self) -> LinkHealth:
        """Return the health of link and vehicle."""

    def send_rpyt(self, setpoint: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust."""

    def send_full_state(self, full_state: FullState) -> None:
        """Send a full state."""

    def send_external_pose(self, pos: Sequence[float], quat: Sequence[float] | None) -> None:
        """Send an external pose: position [m], world, and orientation x y z w; None: unknown."""

    def arm(self) -> None:
        """Request arming."""

    def disarm(self) -> None:
        """Request disarming."""

    def take_off(self, height: float, duration: float) -> None:
        """Command the onboard take-off to a height [m] within `duration` [s]."""

    def land(self, height: float, duration: float) -> None:
        """Stop sending setpoints and command the onboard landing to a height [m] within `duration` [s]."""

    def cut(self) -> None:
        """Cut the motors and lock them."""


class CflibCommander(Protocol):
    """cflib.crazyflie.commander.Commander."""

    def send_setpoint(self, roll: float, pitch: float, yawrate: float, thrust: int) -> None:
        """Send an RPYT setpoint."""

    def send_full_state_setpoint(  # noqa: PLR0913, PLR0917  cflib's signature
        self,
        pos: Sequence[float],
        vel: Sequence[float],
        acc: Sequence[float],
        orientation: Sequence[float],
        rollrate: float,
        pitchrate: float,
        yawrate: float,
    ) -> None:
        """Send a full state."""

    def send_notify_setpoint_stop(self) -> None:
        """Hand over to the high-level commander."""


class CflibHighLevelCommander(Protocol):
    """cflib.crazyflie.high_level_commander.HighLevelCommander."""

    def takeoff(self, absolute_height_m: float, duration_s: float) -> None:
        """Take off."""

    def land(self, absolute_height_m: float, duration_s: float) -> None:
        """Land."""


class Localization(Protocol):
    """cflib.crazyflie.localization.Localization."""

    def send_extpos(self, pos: Sequence[float]) -> None:
        """Send a position."""

    def send_extpose(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Send a pose."""


class CflibSupervisor(Protocol):
    """cflib.crazyflie.supervisor.Supervisor."""

    def send_arming_request(self, *, do_arm: bool) -> None:
        """Arm or disarm."""

    def send_emergency_stop(self) -> None:
        """Stop the motors."""


@dataclass(frozen=True, slots=True)
class CflibSender:
    """Sending parts of cflib's Crazyflie."""

    commander: CflibCommander
    high_level: CflibHighLevelCommander
    localization: Localization
    supervisor: CflibSupervisor

    def send_rpyt(self, setpoint: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust."""
        one = setpoint
        self.commander.send_setpoint(one.roll_deg, one.pitch_deg, one.yaw_rate_deg, one.pwm)

    def send_full_state(self, full_state: FullState) -> None:
        """Send a full state."""
        p, q, r = full_state.ang_vel
        self.commander.send_full_state_setpoint(
            full_state.pos, full_state.vel, full_state.acc, full_state.quat, p, q, r
        )

    def send_external_pose(self, pos: Sequence[float], quat: Sequence[float] | None) -> None:
        """Send an external pose, or a position alone."""
        if quat is None:
            self.localization.send_extpos(pos)
        else:
            self.localization.send_extpose(pos, quat)

    def arm(self) -> None:
        """Request arming."""
        self.supervisor.send_arming_request(do_arm=True)

    def disarm(self) -> None:
        """Request disarming."""
        self.supervisor.send_arming_request(do_arm=False)

    def take_off(self, height: float, duration: float) -> None:
        """Command the onboard take-off to a height [m]."""
        self.commander.send_notify_setpoint_stop()
        self.high_level.takeoff(height, duration)

    def land(self, height: float, duration: float) -> None:
        """Command the onboard landing to a height [m]."""
        self.commander.send_notify_setpoint_stop()
        self.high_level.land(height, duration)

    def cut(self) -> None:
        """Cut the motors and lock them."""
        self.supervisor.send_emergency_stop()
