"""Firmware app compiled for this machine, for simulated vehicles and tests.

The core of an exported folder becomes a shared library; `NativeApp` is one vehicle's state in it. The bytes
that vehicles broadcast and the arithmetic are those of the real app, in single precision.
"""

import ctypes
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from q2q_control.onboard.app_folder import CORE
from q2q_model.signals.values import Array

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-pedantic")
PACKET_BYTES = 17
"""Q2Q_PACKET_BYTES of firmware_app/q2q_app.h."""
AppLibrary = ctypes.CDLL
"""Compiled core of an app."""


class AppBuildError(ValueError):
    """App that cannot be compiled for this machine."""


class _Motion(ctypes.Structure):
    _fields_ = [("values", ctypes.c_float * 9)]


class _Input(ctypes.Structure):
    _fields_ = [
        ("now_us", ctypes.c_uint32),
        ("own", _Motion),
        ("force_up", ctypes.c_float),
        ("thrust", ctypes.c_float),
        ("flying", ctypes.c_bool),
    ]


class StepInput(NamedTuple):
    """Measurements of one step of the controller."""

    now_us: int
    """Time; it wraps at 32 bits."""
    own: Array
    """Position [m], velocity [m/s], body z; world, (9,)."""
    force_up: float
    """Specific force along world z [m/s^2]."""
    thrust: float
    """Commanded thrust over the mass [m/s^2]."""
    flying: bool


def compile_app(folder: Path) -> AppLibrary:
    """Return the core of an exported app as a library.

    Raises:
        AppBuildError: there is no C compiler, or it refuses the sources.
    """
    compiler = shutil.which("cc")
    if compiler is None:
        raise AppBuildError("no C compiler `cc`: install one (Debian: gcc) to fly the app here")
    sources = [str(folder / name) for name in CORE]
    with TemporaryDirectory() as made:
        library = str(Path(made) / "app.so")
        command = [compiler, *FLAGS, "-shared", "-fPIC", *sources, "-o", library, "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise AppBuildError(
                f"{folder} is not an app of export_app: {done.stderr.strip().splitlines()[0]}"
            )
        loaded = AppLibrary(library)  # stays mapped when its file is gone
    try:
        ctypes.c_float.in_dll(loaded, "q2q_acc_per_pwm")
    except ValueError as missing:
        raise AppBuildError(f"{folder} is of an earlier export_app: export it again") from missing
    loaded.q2q_step.restype = loaded.q2q_downwash.restype = ctypes.c_float
    loaded.q2q_hear.restype = loaded.q2q_pack.restype = ctypes.c_bool
    return loaded


class NativeApp:
    """State of one vehicle's app."""

    def __init__(self, library: AppLibrary) -> None:
        self._library = library
        self._neighbours = ctypes.c_uint32.in_dll(library, "q2q_neighbours").value
        self._state = ctypes.create_string_buffer(ctypes.c_uint32.in_dll(library, "q2q_app_bytes").value)
        library.q2q_reset(self._state)

    def step(self, known: StepInput) -> float:
        """Return eta^ along z [m/s^2]: the setpoint's acceleration is less by it."""
        one = _Input(
            known.now_us & 0xFFFFFFFF, _motion(known.own), known.force_up, known.thrust, known.flying
        )
        return float(self._library.q2q_step(self._state, ctypes.byref(one)))

    def downwash(self, own: Array, now_us: int, lead_s: float = 0.0) -> float:
        """Return the prediction without correction [m/s^2], for a motion (9,)."""
        asked = ctypes.byref(_motion(own)), ctypes.c_uint32(now_us), ctypes.c_float(lead_s)
        return float(self._library.q2q_downwash(self._state, *asked))

    def renew_strengths(self, own: Array, now_us: int) -> None:
        """Renew the strength of every source, which steps do one by one; after a prediction."""
        for j in range(1, self._neighbours + 1):
            self._library.q2q_renew_strength(
                self._state, ctypes.byref(_motion(own)), ctypes.c_uint32(now_us), j
            )

    @property
    def acc_per_pwm(self) -> float:
        """Return the thrust that the exported header takes per PWM, over its mass [m/s^2]."""
        return ctypes.c_float.in_dll(self._library, "q2q_acc_per_pwm").value

    @property
    def unheard(self) -> int:
        """Return the number of broadcasts that were not stored, as the places are taken by nearer ones."""
        return int.from_bytes(self._state.raw[-4:], sys.byteorder)  # last member of struct q2q_app

    def hear(self, packet: bytes, stamp_us: int) -> bool:
        """Take a neighbour's broadcast that left it at a time; return whether it was stored."""
        motion = _Motion()
        number = self._library.q2q_unpack(packet, ctypes.byref(motion))
        return self._hear(number, stamp_us, motion)

    def hear_motion(self, number: int, stamp_us: int, motion: Array) -> bool:
        """Take a neighbour's motion (9,) without the rounding of a broadcast."""
        return self._hear(number, stamp_us, _motion(motion))

    def broadcast(self, number: int, motion: Array) -> bytes | None:
        """Return the broadcast of a motion (9,); None, as nothing is sent, if beyond 32.767 m or m/s."""
        packet = ctypes.create_string_buffer(PACKET_BYTES)
        sent = self._library.q2q_pack(ctypes.c_uint8(number), ctypes.byref(_motion(motion)), packet)
        return packet.raw if sent else None

    def _hear(self, number: int, stamp_us: int, motion: _Motion) -> bool:
        asked = ctypes.c_uint8(number), ctypes.c_uint32(stamp_us), ctypes.byref(motion)
        return bool(self._library.q2q_hear(self._state, *asked))


def _motion(values: Array) -> _Motion:
    return _Motion((ctypes.c_float * 9)(*values.tolist()))
