"""Messages that no node should get: invalid bytes, absurd ticks, and plans and poses of nothing."""

import math
import struct
from array import array
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from drawn_values import VEHICLES
from q2q_msgs.msg import Plan, Prediction
from std_msgs.msg import String

from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS, Signal

KINDS = {message: kind for kind, message in MESSAGES.items()}
SECOND = 10**9
FIRST, LAST = -(2**31), 2**31 - 1
"""Ends of a message's seconds, an int32."""


def tick(kind: type[Signal], stamp_ns: int = SECOND, names: tuple[str, ...] = VEHICLES) -> bytes:
    """Return a sound message."""
    return encode(synthetic_signal(kind, 1e-9 * stamp_ns, names), stamp_ns)


def stamped(kind: type[Signal], sec: int, nanosec: int) -> bytes:
    """Return a message with a stamp, possible or not."""
    return tick(kind)[:4] + struct.pack("<iI", sec, nanosec) + tick(kind)[12:]


def filled(kind: type[Signal], value: float) -> bytes:
    """Return a message whose every number is `value`, its status one that does not exist."""
    usual = synthetic_signal(kind, 1.0, VEHICLES)
    rows = {one.attribute: getattr(usual, one.attribute) for one in LAYOUTS[kind].columns}
    columns = {name: np.full_like(old, 255 if old.dtype == np.uint8 else value) for name, old in rows.items()}
    return encode(kind(t=1.0, names=VEHICLES, **columns), SECOND)


INVALID: dict[str, Callable[[type[Signal]], bytes]] = {
    "empty": lambda _: b"",
    "a header only": lambda kind: tick(kind)[:12],
    "cut": lambda kind: tick(kind)[:-9],
    "a name twice": lambda kind: tick(kind).replace(b"cf2", b"cf1"),
    "a second of nanoseconds": lambda kind: stamped(kind, 1, SECOND),
    "the last stamp": lambda kind: stamped(kind, LAST, 2**32 - 1),
    "the first stamp": lambda kind: stamped(kind, FIRST, 0),
}
"""Bytes that every node refuses, and says so."""
INVALID_HEADERS = ("empty", "a second of nanoseconds", "the last stamp", "the first stamp")
ABSURD: dict[str, Callable[[type[Signal]], bytes]] = {
    "before zero": lambda kind: stamped(kind, -1, 5),
    "no vehicles": lambda kind: tick(kind, names=()),
    "many vehicles": lambda kind: tick(kind, names=tuple(f"v{row}" for row in range(100))),
    "a long name": lambda kind: tick(kind, names=("x" * 20_000, "cf1")),
    "names of no topic": lambda kind: tick(kind, names=("ü/é\n", "", "a\0b")),
    "no numbers": lambda kind: filled(kind, math.nan),
    "infinite": lambda kind: filled(kind, math.inf),
    "huge": lambda kind: filled(kind, 1e300),
}
"""Ticks that a node may take."""


def plans() -> list[Plan]:
    """Return plans that nobody can fly."""
    none, huge = Plan(), Plan(names=["cf1"], pieces=[1], order=2, durations=[1.0], coefficients=[1e300] * 8)
    huge.header.stamp.sec = LAST
    unordered = Plan(names=["cf1"], pieces=[1], order=0, durations=[1.0])
    endless = Plan(names=["cf1"], pieces=[1], order=1, durations=[1e300], coefficients=[0.0] * 4)
    named = Plan(names=["", "é" * 9000], pieces=[1, 1], order=1, durations=[1.0] * 2, coefficients=[0.0] * 8)
    return [none, huge, unordered, endless, named]


def predictions() -> list[Prediction]:
    """Return predictions without vehicles, steps or bounds."""
    still = array("f", [0.0] * 12)
    found = [Prediction(), Prediction(names=["cf1"], step=0.0)]
    for names in (["cf2"], ["cf2", "cf2"], ["é" * 9000]):
        for start, step in ((0.0, 1e-300), (-1e18, 0.05), (math.nan, 0.05), (0.0, math.inf), (0.0, 0.05)):
            found.append(Prediction(names=names, start=start, step=step, position=still))
    far = Prediction(names=["cf2"], step=0.05, position=array("f", [3e38, -3e38] * 6))
    late = Prediction(names=["cf1"], step=0.05, position=still)
    late.header.stamp.sec, late.header.stamp.nanosec = LAST, 2**32 - 1
    return [*found, far, late]


def poses() -> list[SimpleNamespace]:
    """Return poses that are not finite, at stamps that are not possible."""
    bad = SimpleNamespace(x=math.nan, y=math.inf, z=1e300, w=math.nan)
    one = SimpleNamespace(name="cf1", pose=SimpleNamespace(position=bad, orientation=bad))
    stamps = [SimpleNamespace(sec=sec, nanosec=nano) for sec, nano in ((LAST, 2**32 - 1), (FIRST, 0), (1, 0))]
    heads = [SimpleNamespace(stamp=stamp) for stamp in stamps]
    return [SimpleNamespace(header=head, poses=some) for head in heads for some in ([], [one], [one, one])]


SPOILED: dict[str, Callable[[], list[object]]] = {
    "Plan": plans,
    "Prediction": predictions,
    "String": lambda: [String(), String(data="[" * 100_000), String(data='{"format": "q2q-model"}')],
    "DiagnosticStatus": lambda: [
        DiagnosticStatus(message=step) for step in ("", "é" * 9000, "hover", "flight")
    ],
    "NamedPoseArray": poses,
    "Status": lambda: [SimpleNamespace(supervisor_info=65535, battery_voltage=math.nan)],
    "LogDataGeneric": lambda: [SimpleNamespace(values=values) for values in ([], [math.nan] * 3, [1.0] * 9)],
}
"""Messages of each type that is not read as bytes."""
