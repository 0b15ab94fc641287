"""Log variables of a vehicle, with the firmware's names, units and signs.

Source: firmware: LOG_ADD of modules/src/stabilizer.c, supervisor.c, crtp_localization_service.c,
estimator/estimator_kalman.c, kalman_core/mm_flow.c, controller/controller_mellinger.c, controller_pid.c,
position_controller_pid.c, hal/src/pm_stm32f4.c, radiolink.c, modules/src/range.c, drivers/src/motors.c,
deck/drivers/src/flowdeck_v1v2.c. Angles are in degrees, pitch nose up (stateEstimate.pitch), the gyroscope's
y is not turned; accelerations in g, stateEstimate.az without gravity; the ...Z groups in mm, mm/s, mm/s^2,
mrad/s, and the ranges in mm.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np

from q2q_model.geometry.quaternion32 import compress_quat
from q2q_model.geometry.rotations import matrix_from_quat, rotate_inverse
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.crtp.tables.toc import Toc, TocEntry
from q2q_sim.firmware.controllers.columns import (
    ATTITUDE_SETPOINT,
    CONTROL,
    I_POS,
    MOTOR,
    POS_TARGET,
    RATE_SETPOINT,
    THRUST_SETPOINT,
    VEL_TARGET,
    Z_AXIS_SETPOINT,
)
from q2q_sim.firmware.estimator import FLOW_HEIGHT_MIN, PIXELS
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.firmware_build import SEES_FLOW
from q2q_sim.plant.body.state_row import ACC, QUAT, RATE

LogValues = Array | tuple[float, ...]
RSSI = 40
"""Signal strength of a vehicle in the same room [-dBm]."""
SEA_LEVEL, LAPSE, ASL_EXPONENT = 1015.7, 0.0065, 0.1902630958
"""Of sensors_bmi088_bmp388.c, which takes heights from pressures: pressure [mbar], lapse [K/m], exponent."""
ROOM_TEMPERATURE = 25.0
"""[deg C], which it assumes."""
LOG_MAX_BLOCKS, LOG_MAX_OPS = 16, 128
"""Largest number of blocks, and of variables in all blocks."""


@dataclass(frozen=True, slots=True)
class Variable:
    """One log variable."""

    group: str
    name: str
    kind: str
    """C type."""
    read: Callable[[Firmware], float]


def _vector(
    names: str, kind: str, read: Callable[[Firmware], LogValues], scale: float = 1.0
) -> tuple[Variable, ...]:
    """Return one variable for each component of `read`; `names` is "group: first second ..."."""
    group, rest = names.split(": ")

    def entry(k: int) -> Callable[[Firmware], float]:
        return lambda firmware: scale * float(read(firmware)[k])

    return tuple(Variable(group, name, kind, entry(k)) for k, name in enumerate(rest.split()))


def _one(name: str, kind: str, read: Callable[[Firmware], float]) -> tuple[Variable, ...]:
    group, last = name.split(".")
    return (Variable(group, last, kind, read),)


def _quat(firmware: Firmware) -> Array:
    return firmware.rows.state[QUAT]


def _acc(firmware: Firmware) -> Array:
    return firmware.rows.state[ACC]


def _legacy_rates(firmware: Firmware) -> Array:
    return np.asarray(firmware.rows.state[RATE] * np.array([1.0, -1.0, 1.0]))


def _vel_body(firmware: Firmware) -> Array:
    return rotate_inverse(_quat(firmware), firmware.rows.vel)


def _compressed_quat(firmware: Firmware) -> float:
    x, y, z, w = _quat(firmware).tolist()
    return float(compress_quat((x, y, z, w)))


def _turned(firmware: Firmware, vector: Array) -> Array:
    """Return a world vector in the frame rotated by the yaw."""
    yaw = math.radians(firmware.rows.attitude_deg[2])
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * vector[0] + s * vector[1], c * vector[1] - s * vector[0], vector[2]])


def _flow(firmware: Firmware) -> LogValues:
    """Return what a flow deck sees [pixels in 10 ms]; 0 without one."""
    if not (firmware.build.flow_deck or not SEES_FLOW.isdisjoint(firmware.build.decks)):
        return 0.0, 0.0
    (x, y, _), rates = _vel_body(firmware), firmware.rows.state[RATE]
    upright = matrix_from_quat(_quat(firmware))[2, 2]
    per_height = upright / max(float(firmware.rows.pos[2]), FLOW_HEIGHT_MIN)
    return PIXELS * (per_height * x - rates[1]), PIXELS * (per_height * y + rates[0])


def _baro(height: float) -> LogValues:
    """Return height above sea level [m], temperature [deg C] and pressure [mbar]; the floor is at the sea.

    The formula ends 45.87 km below the sea: from there on the pressure is NaN, as of powf in C.
    """
    kelvin = ROOM_TEMPERATURE + 273.15
    ratio = 1.0 + LAPSE * height / kelvin
    pressure = SEA_LEVEL * ratio ** (-1.0 / ASL_EXPONENT) if ratio > 0.0 else math.nan
    return height, ROOM_TEMPERATURE, pressure


def _memory(first: int) -> Callable[[Firmware], LogValues]:
    return lambda firmware: firmware.rows.memory[first:]


_STATE = (
    _vector("stateEstimate: x y z", "float", lambda one: one.rows.pos),
    _vector("stateEstimate: vx vy vz", "float", lambda one: one.rows.vel),
    _vector("stateEstimate: ax ay az", "float", _acc, 1.0 / GRAVITY),
    _vector("stateEstimate: roll pitch yaw", "float", lambda one: one.rows.attitude_deg),
    _vector("stateEstimate: qx qy qz qw", "float", _quat),
    _vector("stateEstimateZ: x y z", "int16", lambda one: one.rows.pos, 1e3),
    _vector("stateEstimateZ: vx vy vz", "int16", lambda one: one.rows.vel, 1e3),
    _vector("stateEstimateZ: ax ay az", "int16", lambda one: _acc(one) + np.array([0.0, 0.0, GRAVITY]), 1e3),
    _one("stateEstimateZ.quat", "uint32", _compressed_quat),
    _vector("stateEstimateZ: rateRoll ratePitch rateYaw", "int16", _legacy_rates, 1e3),
)
_CONTROL = (
    _vector("stabilizer: roll pitch yaw", "float", lambda one: one.rows.attitude_deg),
    _vector("stabilizer: thrust", "float", _memory(CONTROL + 3)),
    _vector("ctrltarget: x y z", "float", lambda one: one.flown.pos),
    _vector("ctrltarget: vx vy vz", "float", lambda one: one.flown.vel),
    _vector("ctrltarget: ax ay az", "float", lambda one: one.flown.acc),
    _vector("ctrltarget: roll pitch", "float", lambda one: one.flown.attitude_deg),
    _one("ctrltarget.yaw", "float", lambda one: one.flown.rate_deg[2]),
    _one("ctrltarget.thrust", "float", lambda one: one.flown.thrust_pwm),
    _vector("ctrlMel: cmd_roll cmd_pitch cmd_yaw cmd_thrust", "float", _memory(CONTROL)),
    _vector("ctrlMel: zdx zdy zdz", "float", _memory(Z_AXIS_SETPOINT)),
    _vector("ctrlMel: i_err_x i_err_y i_err_z", "float", _memory(I_POS)),
    _vector("motor: m1 m2 m3 m4", "uint16", _memory(MOTOR)),
)
_CASCADE = (
    _one("controller.cmd_thrust", "float", lambda one: one.rows.memory[CONTROL + 3]),
    _vector("controller: cmd_roll cmd_pitch cmd_yaw", "float", _memory(CONTROL)),
    _vector("controller: r_roll r_pitch r_yaw", "float", _legacy_rates),
    _one("controller.accelz", "float", lambda one: one.rows.specific_force_g[2]),
    _one("controller.actuatorThrust", "float", lambda one: one.rows.memory[THRUST_SETPOINT]),
    _vector("controller: roll pitch yaw", "float", _memory(ATTITUDE_SETPOINT)),
    _vector("controller: rollRate pitchRate yawRate", "float", _memory(RATE_SETPOINT)),
    _one("controller.ctr_yaw", "int16", lambda one: one.rows.memory[CONTROL + 2]),
    _vector("posCtl: targetVX targetVY targetVZ", "float", _memory(VEL_TARGET)),
    _vector("posCtl: targetX targetY targetZ", "float", _memory(POS_TARGET)),
    _vector("posCtl: bodyVX bodyVY", "float", lambda one: _turned(one, one.rows.vel)),
    _vector("posCtl: bodyX bodyY", "float", lambda one: _turned(one, one.rows.pos)),
)
_SENSORS = (
    _vector("acc: x y z", "float", lambda one: one.rows.specific_force_g),
    _vector("gyro: x y z", "float", lambda one: one.rows.rates_deg),
    _vector("kalman: stateX stateY stateZ", "float", lambda one: one.rows.pos),
    _vector("kalman: statePX statePY statePZ", "float", _vel_body),
    _vector("kalman: varX varY varZ varPX varPY varPZ", "float", lambda one: one.estimator.variance),
    _vector("kalman: q0 q1 q2 q3", "float", lambda one: np.roll(_quat(one), 1)),  # w x y z
    _vector("kalman_pred: predNX predNY", "float", _flow),
    _vector("kalman_pred: measNX measNY", "float", _flow),  # an exact sensor (estimator.py)
    _vector("motion: deltaY deltaX", "int16", _flow, -10.0),  # of the sensor, turned, in tenths of a pixel
    _vector("baro: asl temp pressure", "float", lambda one: _baro(float(one.rows.pos[2]))),
    _vector("locSrv: x y z", "float", lambda one: one.external.pos),
    _vector("locSrv: qx qy qz qw", "float", lambda one: one.external.quat),
    _vector("range: front back up left right zrange", "uint16", lambda one: one.rows.ranges_mm(one.build)),
    _one("locSrvZ.tick", "uint16", lambda one: one.external.at_ms),
)
_HEALTH = (
    _one("pm.vbat", "float", lambda one: one.battery.volt),
    _one("pm.vbatMV", "uint16", lambda one: 1e3 * one.battery.volt),
    _one("pm.state", "int8", lambda one: one.battery.state),
    _one("pm.batteryLevel", "uint8", lambda one: one.battery.level),
    _one("radio.rssi", "uint8", lambda _: RSSI),
    _one("radio.isConnected", "uint8", lambda _: 1),
    _one("radio.numRxBc", "uint16", lambda _: 0),
    _one("radio.numRxUc", "uint16", lambda one: one.received),
    _one("sys.testLogParam", "int8", lambda one: one.parameters["system.testLogParam"]),
    _one("sys.canfly", "uint8", lambda one: one.supervisor.may_fly),
    _one("sys.isFlying", "uint8", lambda one: one.supervisor.flying),
    _one("sys.isTumbled", "uint8", lambda one: one.supervisor.tumbled),
    _one("supervisor.info", "uint16", lambda one: one.info),
    _one("supervisor.accNorm", "float", lambda one: float(np.linalg.norm(one.rows.specific_force_g))),
)

VARIABLES: tuple[Variable, ...] = tuple(
    chain.from_iterable((*_STATE, *_CONTROL, *_CASCADE, *_SENSORS, *_HEALTH))
)
"""All variables, in the order of their numbers."""


def log_toc() -> Toc:
    """Return the log's table of contents."""
    entries = [TocEntry(one.group, one.name, TYPES[one.kind].log or 0) for one in VARIABLES]
    return Toc(entries, bytes([LOG_MAX_BLOCKS, LOG_MAX_OPS]))


LOG_TOC = log_toc()
