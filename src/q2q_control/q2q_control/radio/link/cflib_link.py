"""Link to a vehicle through cflib, at any URI it supports (radio://, udp://, usb://).

Packets are sent by the thread of a mailbox (q2q_control.radio.link.mailbox).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from time import monotonic
from typing import TYPE_CHECKING

from q2q_control.flight_procedure.supervisor_info import FLYING, LOCKED, READY
from q2q_control.radio.link.cflib_library import hang_up, new_crazyflie
from q2q_control.radio.link.firmware_settings import FirmwareSettings
from q2q_control.radio.link.logged_values import LoggedValues
from q2q_control.radio.link.mailbox import Mailbox
from q2q_control.radio.link.ping_share import PingShare
from q2q_control.radio.link.setpoints import FullState, RpytSetpoint
from q2q_control.radio.link.vehicle_link import CflibSender, LinkHealth, OnboardPose
from q2q_model.node.exclusive_use import claim
from q2q_model.vehicle.vehicle_uri import resolved_uri

if TYPE_CHECKING:
    from cflib.crtp.crtpstack import CRTPPacket

HEALTH_MS, POSE_MS = 100, 100
"""Periods of the log blocks."""
SILENT_S = 1.0
"""Time without a packet after which a link is lost [s]."""
PING = (15, 0)
"""Port and channel of cflib's pings."""
PING_S = 0.1
"""Period of the pings of a link that counts them [s]."""
AGAIN_S = 3.0
"""Time without a packet after which a link is reopened [s]."""
FLOWN = "it is flying: land it with what flies it; a dry run sends no parameters or poses before it is down"
"""What a dry run reports of a vehicle that flies when it is connected."""


class CflibLink:
    """Link to one vehicle; it reconnects when it is lost."""

    def __init__(
        self,
        name: str,
        uri: str,
        firmware_params: Mapping[str, float],
        cache: str = "",
        *,
        dry_run: bool = False,
    ) -> None:
        """Open the link; `firmware_params` are set once connected, in a dry run once on the ground.

        `cache` is a folder for the tables.

        Raises:
            ValueError: cflib is not installed, or another node of this machine has opened the URI.
        """
        self._uri = uri
        self._crazyflie = new_crazyflie(cache)
        self._claim = claim(resolved_uri(uri))
        self._known = LoggedValues()
        self._pings = PingShare()
        self._counts_pings = uri.startswith("udp://")  # its driver reports no quality
        self._pinged_at = -math.inf
        self._open = self._set_up = self._flown = False
        self._dry_run = dry_run
        self._opened_at = -math.inf
        one = self._crazyflie
        self._sender = CflibSender(one.commander, one.high_level_commander, one.loc, one.supervisor)
        one.fully_connected.add_callback(self._connected)
        one.disconnected.add_callback(self._lost)
        one.packet_received.add_callback(self._on_packet)
        one.connection_failed.add_callback(
            lambda _, why: self._known.console.append(str(why).splitlines()[0])
        )
        self._settings = FirmwareSettings(one.param, firmware_params)
        one.console.receivedChar.add_callback(self._read)
        one.link_statistics.link_quality_updated.add_callback(self._quality)
        if self._counts_pings:
            one.packet_sent.add_callback(self._count_ping)
            one.link_statistics.latency_updated.add_callback(self._count_answer)
        self._mailbox = Mailbox(name)
        self.keep_open()

    def keep_open(self) -> None:
        """Reopen the link if it is lost, and ping its vehicle where pings are counted; call periodically."""
        if self._open and self._counts_pings and monotonic() - self._pinged_at > PING_S:
            self._pinged_at = monotonic()
            self._mailbox.put("ping", self._crazyflie.link_statistics.latency.ping)
        if monotonic() - max(self._known.received, self._opened_at) > AGAIN_S:
            self._opened_at = monotonic()
            self._mailbox.put("open", self._reopen)

    def log_lines(self) -> list[str]:
        """Return and clear the vehicle's console lines and the reasons why links or packets failed."""
        lines, self._known.console = self._known.console, []
        return [line for line in [*lines, *self._mailbox.log_lines()] if line]

    @property
    def pose(self) -> OnboardPose | None:
        """Return the pose that the vehicle last logged."""
        return self._known.pose

    def close(self) -> None:
        """Close the link."""
        self._mailbox.close()
        if self._dry_run:
            hang_up(self._crazyflie)
        else:
            self._crazyflie.close_link()
        self._claim.close()

    def health(self) -> LinkHealth:
        """Return the health of link and vehicle."""
        one, now = self._known, monotonic()
        return LinkHealth(
            connected=self._open and now - one.received < SILENT_S,
            volt=one.volt,
            quality=one.quality,
            armed=one.info & READY == READY,
            locked=bool(one.info & LOCKED),
            flying=bool(one.info & FLYING) if now - one.info_at < SILENT_S else None,
            onboard=None if one.pose is None else one.pose.pos,
            own_hover=self._settings.own_hover,
            wrong=self._wrong(),
        )

    def send_rpyt(self, setpoint: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust; a zero setpoint is never replaced by a newer one."""
        if setpoint.pwm == 0:
            self._mailbox.put_once(lambda: self._sender.send_rpyt(setpoint))
        else:
            self._mailbox.put("setpoint", lambda: self._sender.send_rpyt(setpoint))

    def send_full_state(self, full_state: FullState) -> None:
        """Send a full state."""
        self._mailbox.put("setpoint", lambda: self._sender.send_full_state(full_state))

    def send_external_pose(self, pos: Sequence[float], quat: Sequence[float] | None) -> None:
        """Send an external pose, or a position alone, once the parameters are set."""
        if self._set_up:
            self._mailbox.put("pose", lambda: self._sender.send_external_pose(pos, quat))

    def arm(self) -> None:
        """Request arming."""
        self._mailbox.put_once(self._sender.arm)

    def disarm(self) -> None:
        """Request disarming."""
        self._mailbox.put_once(self._sender.disarm)

    def take_off(self, height: float, duration: float) -> None:
        """Command the onboard take-off."""
        self._mailbox.put_once(lambda: self._sender.take_off(height, duration))

    def land(self, height: float, duration: float) -> None:
        """Command the onboard landing to a height [m], before all that wait."""
        self._mailbox.put_first(lambda: self._sender.land(height, duration))

    def cut(self) -> None:
        """Cut the motors and lock them, before all that wait."""
        self._mailbox.put_first(self._sender.cut)

    def _wrong(self) -> str:
        flown = FLOWN if self._flown else ""
        return flown or self._settings.refusal() or self._not_logged() or self._settings.difference()

    def _not_logged(self) -> str:
        if self._known.not_logged or self._known.pose is not None:
            return self._known.not_logged
        return "has not logged its own estimate yet"

    def _reopen(self) -> None:
        hang_up(self._crazyflie)
        self._crazyflie.open_link(self._uri)

    def _connected(self, _: str) -> None:
        self._known.not_logged = ""
        self._set_up, self._flown = not self._dry_run, False
        if self._set_up:
            self._settings.apply()
        self._log("health", HEALTH_MS, {"pm.vbat": "float", "supervisor.info": "uint16_t"}, self._on_health)
        places = {f"stateEstimate.{axis}": "float" for axis in ("x", "y", "z")}
        turns = {f"stateEstimate.{part}": "FP16" for part in ("qx", "qy", "qz", "qw")}
        self._log("pose", POSE_MS, places | turns, self._on_pose)
        self._open = True

    def _lost(self, _: str) -> None:
        self._open = False
        self._known.quality, self._known.info, self._known.pose = math.nan, 0, None
        self._pings = PingShare()

    def _on_packet(self, _: object) -> None:
        self._known.received = monotonic()

    def _read(self, text: str) -> None:
        *lines, self._known.line = (self._known.line + text).split("\n")
        self._known.console += lines

    def _log(self, name: str, period_ms: int, variables: Mapping[str, str], take: "_Take") -> None:
        from cflib.crazyflie.log import LogConfig

        config = LogConfig(name, period_ms)
        for variable, kind in variables.items():
            config.add_variable(variable, kind)
        try:
            self._crazyflie.log.add_config(config)
        except KeyError as absent:
            missing = f"it does not log the variables that {name} needs ({absent.args[0]}): update it"
            self._known.not_logged = self._known.not_logged or missing
            return
        config.data_received_cb.add_callback(lambda _, data, __: take(data))
        config.start()

    def _on_health(self, data: Mapping[str, float]) -> None:
        self._known.volt, self._known.info = data["pm.vbat"], int(data["supervisor.info"])
        self._known.info_at = monotonic()
        if self._dry_run and not self._set_up:
            self._set_up_unless_flown()

    def _set_up_unless_flown(self) -> None:
        """Set the parameters in a dry run, unless another client flies the vehicle."""
        before, self._flown = self._flown, bool(self._known.info & FLYING)
        if not self._flown:
            self._settings.apply()
            self._set_up = True
        elif not before:
            self._known.console.append(FLOWN)

    def _on_pose(self, data: Mapping[str, float]) -> None:
        pos = (data["stateEstimate.x"], data["stateEstimate.y"], data["stateEstimate.z"])
        quat = tuple(data[f"stateEstimate.{part}"] for part in ("qx", "qy", "qz", "qw"))
        self._known.pose = OnboardPose(pos, quat)

    def _count_ping(self, packet: "CRTPPacket") -> None:
        if (packet.port, packet.channel) == PING:
            self._pings.sent()
            self._known.quality = self._pings.share

    def _count_answer(self, _: float) -> None:
        self._pings.answered()

    def _quality(self, percent: float) -> None:
        self._known.quality = percent / 100.0


_Take = Callable[[Mapping[str, float]], None]
