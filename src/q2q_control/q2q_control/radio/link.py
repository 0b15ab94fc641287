"""Say what a radio needs of the link to one vehicle, and send through cflib's own objects.

`CflibSender` holds the parts of cflib's Crazyflie that encode and send; it is given a live one by
q2q_control.radio.cflib_link, or, in tests, one whose packets go to a simulated vehicle.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from q2q_control.radio.setpoints import FullState, RpytSetpoint
from q2q_model.vehicle.hover_thrust import OwnHover


@dataclass(frozen=True, slots=True)
class LinkHealth:
    """Hold what is known of a link and of the vehicle behind it."""

    connected: bool
    volt: float = math.nan
    """Battery [V]; NaN while unknown."""
    quality: float = math.nan
    """Share of packets that are acknowledged; NaN where the link does not say."""
    armed: bool = False
    """Armed, and ready to fly."""
    locked: bool = False
    """The vehicle has stopped for good and must be restarted."""
    onboard: tuple[float, float, float] | None = None
    """Position that the vehicle estimates [m], world; None while it has not said."""
    own_hover: OwnHover | None = None
    """What the vehicle itself takes for hover; None while it has not said."""
    wrong: str = ""
    """What is wrong with the vehicle's parameters; empty where nothing is."""


class VehicleLink(Protocol):
    """Reach one vehicle."""

    def health(self) -> LinkHealth:
        """Return how the link and the vehicle are."""

    def send_rpyt(self, stick: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust."""

    def send_full_state(self, wanted: FullState) -> None:
        """Send a full state."""

    def send_place(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Send an external pose: position [m], world, and orientation x y z w."""

    def arm(self) -> None:
        """Ask the vehicle to arm."""

    def disarm(self) -> None:
        """Ask the vehicle to disarm."""

    def take_off(self, height: float, duration: float) -> None:
        """Let the vehicle climb to a height [m] by itself within `duration` [s]."""

    def land(self, duration: float) -> None:
        """Stop sending setpoints and let the vehicle land by itself within `duration` [s]."""

    def stop(self) -> None:
        """Stop the motors for good."""


class CflibCommander(Protocol):
    """Match cflib.crazyflie.commander.Commander."""

    def send_setpoint(self, roll: float, pitch: float, yawrate: float, thrust: int) -> None:
        """Send a stick."""

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
        """Give way to the high-level commander."""


class CflibHighLevelCommander(Protocol):
    """Match cflib.crazyflie.high_level_commander.CflibHighLevelCommander."""

    def takeoff(self, absolute_height_m: float, duration_s: float) -> None:
        """Take off."""

    def land(self, absolute_height_m: float, duration_s: float) -> None:
        """Land."""


class Localization(Protocol):
    """Match cflib.crazyflie.localization.Localization."""

    def send_extpose(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Send a pose."""


class CflibSupervisor(Protocol):
    """Match cflib.crazyflie.supervisor.Supervisor."""

    def send_arming_request(self, *, do_arm: bool) -> None:
        """Arm or disarm."""

    def send_emergency_stop(self) -> None:
        """Stop the motors."""


@dataclass(frozen=True, slots=True)
class CflibSender:
    """Hold the sending parts of cflib's Crazyflie."""

    commander: CflibCommander
    high_level: CflibHighLevelCommander
    place: Localization
    supervisor: CflibSupervisor

    def send_rpyt(self, stick: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust."""
        self.commander.send_setpoint(stick.roll_deg, stick.pitch_deg, stick.yaw_rate_deg, stick.pwm)

    def send_full_state(self, wanted: FullState) -> None:
        """Send a full state."""
        p, q, r = wanted.ang_vel
        self.commander.send_full_state_setpoint(wanted.pos, wanted.vel, wanted.acc, wanted.quat, p, q, r)

    def send_place(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Send an external pose."""
        self.place.send_extpose(pos, quat)

    def arm(self) -> None:
        """Ask the vehicle to arm."""
        self.supervisor.send_arming_request(do_arm=True)

    def disarm(self) -> None:
        """Ask the vehicle to disarm."""
        self.supervisor.send_arming_request(do_arm=False)

    def take_off(self, height: float, duration: float) -> None:
        """Let the vehicle climb to a height [m] by itself."""
        self.commander.send_notify_setpoint_stop()
        self.high_level.takeoff(height, duration)

    def land(self, duration: float) -> None:
        """Let the vehicle land by itself."""
        self.commander.send_notify_setpoint_stop()
        self.high_level.land(0.0, duration)

    def stop(self) -> None:
        """Stop the motors for good."""
        self.supervisor.send_emergency_stop()
