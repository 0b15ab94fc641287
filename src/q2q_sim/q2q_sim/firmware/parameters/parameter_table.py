"""Table of the firmware's parameters with types, stock values and sources.

The order is that of the table of contents. "persistent" ones can be stored in the vehicle's EEPROM.
Sources: F = firmware. Stock values of ctrlMel.mass, massThrust and the Mellinger gains in N/m are replaced by
those of the airframe (parameter_values.defaults_of), those of decks by the build (firmware_build.Build). Some
are kept because clients set or read them, without effect: stabilizer.estimator (no other estimator here),
commander.enHighLevel (nothing in F either, since 2021), flightmode.yawMode (X only), kalman.initialYaw and
the noises of an attitude that is known here, the lighthouse, lights, sounds, tests of motors, battery and
memory, the memory card, and what dumps or resets the processor (system).
"""

from dataclasses import dataclass

from q2q_model.vehicle.thrust_map import MASS_THRUST

FirmwareValue = float | int


@dataclass(frozen=True, slots=True)
class Definition:
    """One parameter of the firmware."""

    name: str
    """group.name"""
    kind: str
    """C type: uint8 uint16 uint32 int8 int16 int32 float."""
    default: FirmwareValue
    persistent: bool = False
    read_only: bool = False

    @property
    def group(self) -> str:
        """Return the group, before the dot."""
        return self.name.split(".")[0]

    @property
    def last(self) -> str:
        """Return the name within the group, after the dot."""
        return self.name.split(".")[1]


def _floats(group: str, values: dict[str, float]) -> tuple[Definition, ...]:
    return tuple(
        Definition(f"{group}.{name}", "float", value, persistent=True) for name, value in values.items()
    )


def _gains(group: str, axes: dict[str, tuple[float, float, float]], suffixes: str) -> tuple[Definition, ...]:
    """Return kp, ki, kd of each axis; `suffixes` are their three names after the axis."""
    names = suffixes.split()
    flat = {axis + names[k]: gains[k] for axis, gains in axes.items() for k in range(3)}
    return _floats(group, flat)


MODES = (  # F modules/src/crtp_commander_rpyt.c, commander.c, stabilizer.c, supervisor.c
    Definition("commander.enHighLevel", "uint8", 0),
    Definition("flightmode.althold", "uint8", 0),
    Definition("flightmode.poshold", "uint8", 0),
    Definition("flightmode.posSet", "uint8", 0),
    Definition("flightmode.yawMode", "uint8", 2),
    Definition("flightmode.stabModeRoll", "uint8", 1),
    Definition("flightmode.stabModePitch", "uint8", 1),
    Definition("flightmode.stabModeYaw", "uint8", 0),
    Definition("stabilizer.estimator", "uint8", 2),
    Definition("stabilizer.controller", "uint8", 1),
    Definition("stabilizer.stop", "uint8", 0),
    Definition("supervisor.prefltTimeout", "uint16", 30000, persistent=True),  # [ms], platform_defaults.h
    Definition("supervisor.landedTimeout", "uint16", 3000, persistent=True),  # [ms], the same
    Definition("supervisor.tmblChckEn", "uint8", 1, persistent=True),
    Definition("hlCommander.vtoff", "float", 0.5),  # [m/s], crtp_commander_high_level.c
    Definition("hlCommander.vland", "float", 0.5),
    Definition("hlCommander.groupmask", "uint8", 0),
)
ESTIMATION = (  # F modules/interface/kalman_core/kalman_core_params_defaults.h, crtp_localization_service.c
    Definition("kalman.resetEstimation", "uint8", 0),
    Definition("kalman.pNAcc_xy", "float", 0.5, persistent=True),
    Definition("kalman.pNAcc_z", "float", 1.0, persistent=True),
    Definition("kalman.initialX", "float", 0.0),
    Definition("kalman.initialY", "float", 0.0),
    Definition("kalman.initialZ", "float", 0.0),
    Definition("kalman.initialYaw", "float", 0.0),  # [rad]
    *_floats(
        "kalman",
        {"pNPos": 0.0, "pNVel": 0.0, "pNAtt": 0.0, "mNBaro": 2.0, "mNGyro_rollpitch": 0.1, "mNGyro_yaw": 0.1},
    ),
    Definition("kalman.robustTdoa", "uint8", 0),
    Definition("kalman.robustTwr", "uint8", 0),
    Definition("lighthouse.systemType", "uint8", 2),  # lighthouse_core.c
    Definition("lighthouse.method", "uint8", 1),
    Definition("motion.disable", "uint8", 0),  # flowdeck_v1v2.c
    Definition("locSrv.extPosStdDev", "float", 0.01),
    Definition("locSrv.extQuatStdDev", "float", 4.5e-3),
    Definition("pm.lowVoltage", "float", 3.2, persistent=True),  # [V], platform_defaults_cf2.h
    Definition("pm.criticalLowVoltage", "float", 3.0, persistent=True),
)
MELLINGER = _floats(  # F modules/src/controller/controller_mellinger.c
    "ctrlMel",
    {
        "kp_xy": 0.4, "kd_xy": 0.2, "ki_xy": 0.05, "i_range_xy": 2.0,
        "kp_z": 1.25, "kd_z": 0.4, "ki_z": 0.05, "i_range_z": 0.4,
        "mass": 0.029, "massThrust": MASS_THRUST,
        "kR_xy": 70000.0, "kR_z": 60000.0, "kw_xy": 20000.0, "kw_z": 12000.0,
        "ki_m_xy": 0.0, "ki_m_z": 500.0, "kd_omega_rp": 200.0, "i_range_m_xy": 1.0, "i_range_m_z": 1500.0,
    },
)  # fmt: skip
VELOCITY_PID = _gains(  # F platform/interface/platform_defaults_cf2.h
    "velCtlPid", {"vx": (25.0, 1.0, 0.0), "vy": (25.0, 1.0, 0.0), "vz": (25.0, 15.0, 0.0)}, "Kp Ki Kd"
)
VELOCITY_FEED = _floats("velCtlPid", {"vxKFF": 0.0, "vyKFF": 0.0, "vzKFF": 0.0})  # F the same
POSITION_PID = (
    *_gains("posCtlPid", {"x": (2.0, 0.0, 0.0), "y": (2.0, 0.0, 0.0), "z": (2.0, 0.5, 0.0)}, "Kp Ki Kd"),
    Definition("posCtlPid.thrustBase", "uint16", 36000, persistent=True),
    Definition("posCtlPid.thrustMin", "uint16", 20000, persistent=True),
    *_floats("posCtlPid", {"rLimit": 20.0, "pLimit": 20.0, "xVelMax": 1.0, "yVelMax": 1.0, "zVelMax": 1.0}),
)
ATTITUDE_PID = _gains(
    "pid_attitude",
    {"roll": (6.0, 3.0, 0.0), "pitch": (6.0, 3.0, 0.0), "yaw": (6.0, 1.0, 0.35)},
    "_kp _ki _kd",
)
RATE_PID = _gains(
    "pid_rate",
    {"roll": (250.0, 500.0, 2.5), "pitch": (250.0, 500.0, 2.5), "yaw": (120.0, 16.7, 0.0)},
    "_kp _ki _kd",
)
LIGHTS_AND_SOUNDS = (  # F drivers/src/led.c, deck/drivers/src/ledring12.c, Kconfig, modules/src/sound_cf2.c
    Definition("led.bitmask", "uint8", 0),
    Definition("ring.effect", "uint8", 6, persistent=True),
    Definition("ring.neffect", "uint32", 19, read_only=True),
    Definition("ring.solidRed", "uint8", 20),
    Definition("ring.solidGreen", "uint8", 20),
    Definition("ring.solidBlue", "uint8", 20),
    Definition("ring.headlightEnable", "uint8", 0),
    Definition("ring.emptyCharge", "float", 3.1),  # [V]
    Definition("ring.fullCharge", "float", 4.2),
    Definition("ring.fadeColor", "uint32", 0),
    Definition("ring.fadeTime", "float", 0.5),  # [s]
    Definition("sound.effect", "uint8", 0, persistent=True),
)
TESTS = (  # F modules/src/health.c, mem.c
    Definition("health.startPropTest", "uint8", 0),
    Definition("health.startBatTest", "uint8", 0),
    Definition("memTst.resetW", "uint8", 0),
)
CARD = (  # F deck/drivers/src/usddeck.c
    Definition("usd.canLog", "uint8", 0, read_only=True),
    Definition("usd.logging", "uint8", 0),
)
DECKS = tuple(  # F deck/drivers/src: isInit of each driver
    Definition(f"deck.{name}", "uint8", 0, read_only=True)
    for name in (
        "bcAI", "bcActiveMarker", "bcBigQuad", "bcBuzzer", "bcDWM1000", "bcFlow", "bcFlow2", "bcLedRing",
        "bcLighthouse4", "bcLoco", "bcMultiranger", "bcOA", "bcUSD", "bcZRanger", "bcZRanger2",
    )
)  # fmt: skip
POWER = (  # F modules/src/power_distribution_quadrotor.c; IDLE_PWM where the build requires arming
    Definition("powerDist.idleThrust", "uint32", 0, persistent=True),
)
IDLE_PWM = 7000
"""Duty of an armed motor without thrust: MOTORS_DEFAULT_IDLE_THRUST, F modules/src/Kconfig [PWM]."""
CPPM = _floats(  # F modules/src/crtp_commander_generic.c: [deg/s], [deg] at the end of a stick
    "cppm",
    {"rateRoll": 720.0, "ratePitch": 720.0, "angPitch": 50.0, "angRoll": 50.0, "rateYaw": 400.0},
)
IDENTITY = (  # F modules/src/system.c, info.c
    Definition("system.selftestPassed", "int8", 1, read_only=True),
    Definition("system.assertInfo", "uint8", 0),
    Definition("system.testLogParam", "uint8", 0),
    Definition("system.doAssert", "uint8", 0),
    Definition("system.taskDump", "uint8", 0),  # sysload.c
    Definition("system.storageStats", "uint8", 0),  # hal/src/storage.c
    Definition("system.storageReformat", "uint8", 0),
    Definition("system.highlight", "uint8", 0),  # ledring12.c
    Definition("cpu.flash", "uint16", 1024, read_only=True),  # [kB], STM32F405
    Definition("cpu.id0", "uint32", 0, read_only=True),
    Definition("cpu.id1", "uint32", 0, read_only=True),
    Definition("cpu.id2", "uint32", 0, read_only=True),
    Definition("firmware.revision0", "uint32", 0x2A18FC29, read_only=True),  # the commit this follows
    Definition("firmware.revision1", "uint16", 0x9D7B, read_only=True),
    Definition("firmware.modified", "uint8", 1, read_only=True),
)

TABLE = (
    *MODES,
    *ESTIMATION,
    *MELLINGER,
    *VELOCITY_PID,
    *VELOCITY_FEED,
    *POSITION_PID,
    *ATTITUDE_PID,
    *RATE_PID,
    *LIGHTS_AND_SOUNDS,
    *TESTS,
    *CARD,
    *DECKS,
    *POWER,
    *CPPM,
    *IDENTITY,
)
"""All parameters, in the order of their ids."""

GAINS = tuple(
    one.name for one in (*MELLINGER, *VELOCITY_PID, *VELOCITY_FEED, *POSITION_PID, *ATTITUDE_PID, *RATE_PID)
)
"""Parameters of the compiled controllers, in the order of their columns (columns.py)."""
