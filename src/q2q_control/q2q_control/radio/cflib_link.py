"""Reach vehicles through cflib, at any URI it knows (radio://, udp://, usb://).

cflib is needed only when a link is made. Each link has a thread of its own, because cflib's radio driver
blocks while the radio is busy: what is to be sent waits in a mailbox where a newer stick or place replaces an
older one, so that a slow radio costs rate, not delay.
"""

import logging
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from time import monotonic
from typing import TYPE_CHECKING

from q2q_control.flight_procedure.supervisor_info import LOCKED, READY
from q2q_control.radio.firmware_params import TableEntry, difference, unsettable
from q2q_control.radio.link import CflibSender, LinkHealth
from q2q_control.radio.ping_share import PingShare
from q2q_control.radio.setpoints import FullState, RpytSetpoint
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover

if TYPE_CHECKING:
    from cflib.crazyflie import Crazyflie
    from cflib.crazyflie.log import LogConfig
    from cflib.crtp.crtpstack import CRTPPacket

HEALTH_MS, POSE_MS = 100, 100
"""Periods of the log blocks."""
SILENT_S = 1.0
"""A link over which nothing has come for this long is lost [s]."""
PING = (15, 0)
"""Port and channel of cflib's pings."""
AGAIN_S = 3.0
"""One over which nothing has come for this long is opened again [s]."""


@dataclass(frozen=True, slots=True)
class OnboardPose:
    """Pose estimated on board a vehicle."""

    pos: tuple[float, float, float]
    """[m], world."""
    quat: tuple[float, ...]
    """x y z w, body to world."""


@dataclass(slots=True)
class _Known:
    """Last values logged by a vehicle."""

    volt: float = math.nan
    info: int = 0
    quality: float = math.nan
    pose: OnboardPose | None = None
    heard: float = -math.inf
    """When a packet last came [s]."""
    own_hover: OwnHover | None = None
    held: dict[str, float] = field(default_factory=dict)
    """What it answers of the parameters that were set."""
    refused: list[str] = field(default_factory=list)
    """Why it cannot be given parameters, or does not log what is needed."""
    words: list[str] = field(default_factory=list)
    """Whole lines."""
    line: str = ""
    """What its console has begun."""


class Mailbox:
    """Newest packet of each kind, sent from a thread of its own."""

    def __init__(self, name: str) -> None:
        self._waiting: dict[str, Callable[[], None]] = {}
        self._serial = count()
        self._change = threading.Condition()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name=f"radio {name}", daemon=True)
        self._thread.start()

    def put(self, kind: str, send: Callable[[], None]) -> None:
        """Send this soon, instead of what waits of the same kind."""
        with self._change:
            self._waiting.pop(kind, None)
            self._waiting[kind] = send
            self._change.notify()

    def put_once(self, send: Callable[[], None]) -> None:
        """Send this soon, whatever else waits."""
        self.put(f"once {next(self._serial)}", send)

    def put_first(self, send: Callable[[], None]) -> None:
        """Send this next, instead of all that waits."""
        with self._change:
            self._waiting.clear()
        self.put_once(send)

    def close(self) -> None:
        """Send what waits, then nothing more."""
        with self._change:
            self._ended = True
            self._change.notify()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._change:
                while not self._waiting and not self._ended:
                    self._change.wait()
                if not self._waiting:
                    return
                kind = next(iter(self._waiting))
                send = self._waiting.pop(kind)
            with suppress(OSError):  # the link says by itself when it is lost
                send()


class CflibLink:
    """Link to one vehicle; it reconnects when it is lost."""

    def __init__(self, name: str, uri: str, firmware_params: Mapping[str, float], cache: str = "") -> None:
        """Open the link; `firmware_params` are set once it is connected, `cache` keeps the tables.

        Raises:
            ValueError: cflib is not installed.
        """
        self._uri = uri
        self._params = dict(firmware_params)
        self._crazyflie = _crazyflie(cache)
        self._known = _Known()
        self._pings = PingShare()
        self._open = False
        self._opened_at = -math.inf
        one = self._crazyflie
        self._sender = CflibSender(one.commander, one.high_level_commander, one.loc, one.supervisor)
        one.fully_connected.add_callback(self._connected)
        one.disconnected.add_callback(self._lost)
        one.packet_received.add_callback(self._heard)
        one.connection_failed.add_callback(lambda _, why: self._known.words.append(str(why).splitlines()[0]))
        for parameter in self._params:
            one.param.add_update_callback(*parameter.split(".", 1), self._read_back)
        one.console.receivedChar.add_callback(self._read)
        one.link_statistics.link_quality_updated.add_callback(self._quality)
        if uri.startswith("udp://"):  # its driver tells of no quality
            one.packet_sent.add_callback(self._count_ping)
            one.link_statistics.latency_updated.add_callback(self._count_answer)
        self._mailbox = Mailbox(name)
        self.keep_open()

    def keep_open(self) -> None:
        """Open the link again if it is lost; call now and then."""
        silent = monotonic() - max(self._known.heard, self._opened_at)
        if silent > AGAIN_S:
            self._opened_at = monotonic()
            self._mailbox.put("open", self._reopen)

    def said(self) -> list[str]:
        """Return, and forget, what the vehicle wrote on its console and why links failed."""
        words, self._known.words = self._known.words, []
        return [word for word in words if word]

    @property
    def pose(self) -> OnboardPose | None:
        """Return the pose that the vehicle last logged."""
        return self._known.pose

    def close(self) -> None:
        """Close the link."""
        self._mailbox.close()
        self._crazyflie.close_link()

    def health(self) -> LinkHealth:
        """Return how the link and the vehicle are."""
        one = self._known
        return LinkHealth(
            connected=self._open and monotonic() - one.heard < SILENT_S,
            volt=one.volt,
            quality=one.quality,
            armed=one.info & READY == READY,
            locked=bool(one.info & LOCKED),
            onboard=None if one.pose is None else one.pose.pos,
            own_hover=one.own_hover,
            wrong=self._wrong(),
        )

    def send_rpyt(self, stick: RpytSetpoint) -> None:
        """Send roll, pitch, yaw rate, thrust; a stick without thrust is never replaced by a newer one."""
        if stick.pwm == 0:
            self._mailbox.put_once(lambda: self._sender.send_rpyt(stick))
        else:
            self._mailbox.put("setpoint", lambda: self._sender.send_rpyt(stick))

    def send_full_state(self, wanted: FullState) -> None:
        """Send a full state."""
        self._mailbox.put("setpoint", lambda: self._sender.send_full_state(wanted))

    def send_place(self, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Send an external pose."""
        self._mailbox.put("place", lambda: self._sender.send_place(pos, quat))

    def arm(self) -> None:
        """Ask the vehicle to arm."""
        self._mailbox.put_once(self._sender.arm)

    def disarm(self) -> None:
        """Ask the vehicle to disarm."""
        self._mailbox.put_once(self._sender.disarm)

    def take_off(self, height: float, duration: float) -> None:
        """Let the vehicle climb by itself."""
        self._mailbox.put_once(lambda: self._sender.take_off(height, duration))

    def land(self, duration: float) -> None:
        """Let the vehicle land by itself, instead of what waits."""
        self._mailbox.put_first(lambda: self._sender.land(duration))

    def stop(self) -> None:
        """Stop the motors for good, before anything else."""
        self._mailbox.put_first(self._sender.stop)

    def _wrong(self) -> str:
        if self._known.refused:
            return self._known.refused[0]
        if self._known.pose is None:
            return "has not logged its own estimate yet"
        return difference(self._params, self._known.held)

    def _reopen(self) -> None:
        self._crazyflie.close_link()
        self._crazyflie.open_link(self._uri)

    def _connected(self, _: str) -> None:
        self._known.held.clear()
        table = self._table()
        refused = unsettable(self._params, table)
        self._known.refused = list(refused.values())
        for name in self._params.keys() - refused.keys():
            self._crazyflie.param.set_value(name, self._params[name])
            self._crazyflie.param.request_param_update(name)
        if table.keys() >= set(OWN_PARAMETERS):
            read = {name: float(self._crazyflie.param.get_value(name)) for name in OWN_PARAMETERS}
            self._known.own_hover = OwnHover(*(self._params.get(name, value) for name, value in read.items()))
        self._log("health", HEALTH_MS, {"pm.vbat": "float", "supervisor.info": "uint16_t"}, self._on_health)
        places = {f"stateEstimate.{axis}": "float" for axis in ("x", "y", "z")}
        turns = {f"stateEstimate.{part}": "FP16" for part in ("qx", "qy", "qz", "qw")}
        self._log("pose", POSE_MS, places | turns, self._on_pose)
        self._open = True

    def _table(self) -> dict[str, TableEntry]:
        """Return the vehicle's table of parameters."""
        return {
            f"{group}.{name}": TableEntry(element.pytype, element.get_readable_access() == "RW")
            for group, elements in self._crazyflie.param.toc.toc.items()
            for name, element in elements.items()
        }

    def _lost(self, _: str) -> None:
        self._open = False

    def _read_back(self, name: str, value: str) -> None:
        self._known.held[name] = float(value)

    def _heard(self, _: object) -> None:
        self._known.heard = monotonic()

    def _read(self, text: str) -> None:
        *lines, self._known.line = (self._known.line + text).split("\n")
        self._known.words += lines

    def _log(self, name: str, period_ms: int, variables: Mapping[str, str], take: "_Take") -> None:
        config = _log_config(name, period_ms)
        for variable, kind in variables.items():
            config.add_variable(variable, kind)
        try:
            self._crazyflie.log.add_config(config)
        except KeyError as absent:
            self._known.refused.append(f"it does not log what {name} needs ({absent.args[0]}): update it")
            return
        config.data_received_cb.add_callback(lambda _, data, __: take(data))
        config.start()

    def _on_health(self, data: Mapping[str, float]) -> None:
        self._known.volt, self._known.info = data["pm.vbat"], int(data["supervisor.info"])

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


def _crazyflie(cache: str) -> "Crazyflie":
    """Return a new Crazyflie; raise ValueError where cflib is missing."""
    try:
        import cflib.crtp
        from cflib.crazyflie import Crazyflie
    except ImportError as missing:
        raise ValueError(
            "cflib is not installed: `pip install cflib==0.1.34`, or scripts/setup --dev"
        ) from missing
    logging.getLogger("cflib").setLevel(logging.ERROR)  # it warns of every lost link; the node says so itself
    cflib.crtp.init_drivers()
    return Crazyflie(rw_cache=cache or None)


def _log_config(name: str, period_ms: int) -> "LogConfig":
    from cflib.crazyflie.log import LogConfig

    return LogConfig(name, period_ms)
