"""Physics step of many quadcopters, eight at a time, in a loop that compiles to vector instructions.

The equations are the functions of quadcopter, rigid_body and rotors. Eight rows are copied into a block that
holds one line of eight lanes for each column: a loop over the lanes has no branch, and reads and writes at
distances that the compiler knows. The inverse tangent and sine of roll and pitch are those of the C library,
row by row. A lane that needs a branch (a rotor at its limit, motors off, a turn beyond the series, the
ground) is discarded, and `advance` steps its row. Rows come out as `advance` writes them, to the last bit:
vector instructions round as scalar ones do.
"""

from q2q_control.attitude.allocation_kernel import unlimited_rotors
from q2q_control.attitude.attitude_law import AttitudeGains, AxisValues, attitude_torque
from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array, Four, Three
from q2q_sim.plant.body.quadcopter import GAIN1, Body, advance, tilt
from q2q_sim.plant.body.rigid_body import (
    SMALL_SQUARE,
    acceleration,
    half_turn_squared,
    quat_after,
    rate_after,
    small_half_turn,
)
from q2q_sim.plant.body.rotors import excess_share, rotor_torque
from q2q_sim.plant.body.state_row import (
    AX,
    ETA_X,
    ETA_Y,
    ETA_Z,
    F1,
    QX,
    ROTOR_MAX1,
    STATE_WIDTH,
    TX,
    VX,
    P,
    X,
    Y,
    Z,
)

LANES = 8
"""Rows of a block."""
COMMAND, COMMAND_WIDTH = STATE_WIDTH, 4
"""First line after those of the state, and their number: thrust [N], roll, pitch [rad], yaw rate [rad/s]."""
DRIVE, DRIVE_WIDTH = COMMAND + COMMAND_WIDTH, 7
"""Acceleration by wind [m/s^2], world, then the gain of each rotor."""
TILT = DRIVE + DRIVE_WIDTH
"""Roll, pitch before the step [rad], and 0 for the yaw."""
VALID = TILT + 3
"""1 if the lane needed no branch, else 0."""
BLOCK_WIDTH = VALID + 1

IN_LOOP: dict[str, object] = {**BORROWING, "forceinline": True}
"""Options of functions of one lane: a call that is left in the loop over the lanes keeps it from vectors."""

StepMemory = tuple[Array, Array]
"""Workspace: a block (BLOCK_WIDTH * LANES,), and rotor thrusts of a row (4,)."""


@compiled(**IN_LOOP)
def _three(block: Array, line: int, lane: int) -> Three:
    """Return a lane of three lines."""
    at = line * LANES + lane
    return block[at], block[at + LANES], block[at + 2 * LANES]


@compiled(**IN_LOOP)
def _four(block: Array, line: int, lane: int) -> Four:
    """Return a lane of four lines."""
    at = line * LANES + lane
    return block[at], block[at + LANES], block[at + 2 * LANES], block[at + 3 * LANES]


@compiled(**IN_LOOP)
def _put_three(block: Array, line: int, lane: int, values: Three) -> None:
    """Write a lane of three lines."""
    at = line * LANES + lane
    block[at], block[at + LANES], block[at + 2 * LANES] = values


@compiled(**IN_LOOP)
def _put_four(block: Array, line: int, lane: int, values: Four) -> None:
    """Write a lane of four lines."""
    at = line * LANES + lane
    block[at], block[at + LANES], block[at + 2 * LANES], block[at + 3 * LANES] = values


@compiled(**BORROWING)
def _load(state: Array, commands: Array, drive: Array, i: int, place: tuple[Array, int]) -> None:
    """Copy row i into a lane of a block, `place` = (block, lane)."""
    block, lane = place
    for column in range(STATE_WIDTH):
        block[column * LANES + lane] = state[i, column]
    for column in range(COMMAND_WIDTH):
        block[(COMMAND + column) * LANES + lane] = commands[i, column]
    for column in range(DRIVE_WIDTH):
        block[(DRIVE + column) * LANES + lane] = drive[i, column]
    _put_three(block, TILT, lane, tilt(_four(block, QX, lane)))


@compiled(**IN_LOOP)
def _commanded(block: Array, lane: int, body: Body) -> tuple[Four, bool]:
    """Return the rotor thrusts [N] of a lane's command, and whether the motors run and no limit is active."""
    lever, drag, _ = body.frame
    thrust, roll, pitch, yaw_rate = _four(block, COMMAND, lane)
    torque_now = rotor_torque(_four(block, F1, lane), lever, drag)
    desired, attitude = (roll, pitch, yaw_rate), _three(block, TILT, lane)
    tx, ty, tz = attitude_torque(attitude, _three(block, P, lane), torque_now, desired, body.gains)
    rotors, fits = unlimited_rotors((thrust, tx, ty, tz), body.frame)
    return rotors, fits & (thrust > 0.0)


@compiled(**IN_LOOP)
def _lagged(block: Array, lane: int, commanded: Four, decay: float) -> tuple[Four, bool]:
    """Return the rotor thrusts [N] of a lane after the step, and whether all of them lose alike."""
    f1, f2, f3, f4 = _four(block, F1, lane)
    gain = _four(block, DRIVE + GAIN1, lane)
    lost = excess_share(commanded, _four(block, ROTOR_MAX1, lane))
    t1, t2 = gain[0] * max(commanded[0] - lost, 0.0), gain[1] * max(commanded[1] - lost, 0.0)
    t3, t4 = gain[2] * max(commanded[2] - lost, 0.0), gain[3] * max(commanded[3] - lost, 0.0)
    alike = min(commanded[0], commanded[1], commanded[2], commanded[3]) >= lost
    after = (
        t1 + (f1 - t1) * decay,
        t2 + (f2 - t2) * decay,
        t3 + (f3 - t3) * decay,
        t4 + (f4 - t4) * decay,
    )
    return after, alike


@compiled(**IN_LOOP)
def _translated(block: Array, lane: int, rotors: Four, body: Body) -> tuple[Three, Three, Three]:
    """Return acceleration, velocity and position of a lane after the step."""
    h, wind = body.step, _three(block, DRIVE, lane)
    push = (
        wind[X] + block[ETA_X * LANES + lane],
        wind[Y] + block[ETA_Y * LANES + lane],
        wind[Z] + block[ETA_Z * LANES + lane],
    )
    ax, ay, az = acceleration(_four(block, QX, lane), rotors, push, body.mass)
    (bx, by, bz), (x, y, z) = _three(block, VX, lane), _three(block, X, lane)
    vx, vy, vz = bx + ax * h, by + ay * h, bz + az * h
    pos = (x + 0.5 * (bx + vx) * h, y + 0.5 * (by + vy) * h, z + 0.5 * (bz + vz) * h)
    return (ax, ay, az), (vx, vy, vz), pos


@compiled(**IN_LOOP)
def _rotated(block: Array, lane: int, rotors: Four, body: Body) -> tuple[Three, Four, bool]:
    """Return rate and attitude of a lane after the step, and whether the series hold."""
    lever, drag, _ = body.frame
    tx, ty, tz = rotor_torque(rotors, lever, drag)
    ax, ay, az = _three(block, TX, lane)
    rate = rate_after(_three(block, P, lane), (tx + ax, ty + ay, tz + az), body.gains.inertia, body.step)
    square = half_turn_squared(rate, body.step)
    quat = quat_after(_four(block, QX, lane), rate, small_half_turn(square), body.step)
    return rate, quat, square <= SMALL_SQUARE


@compiled(**BORROWING)
def _step_block(block: Array, body: Body) -> None:
    """Advance all lanes by a step; write which of them are valid."""
    for lane in range(LANES):
        commanded, unlimited = _commanded(block, lane, body)
        rotors, alike = _lagged(block, lane, commanded, body.decay)
        acc, vel, pos = _translated(block, lane, rotors, body)
        rate, quat, exact = _rotated(block, lane, rotors, body)
        valid = 1.0 if unlimited & alike & exact & (pos[Z] >= 0.0) else 0.0
        _put_three(block, X, lane, pos)  # all is read before anything is written: else no vectors
        _put_three(block, VX, lane, vel)
        _put_four(block, QX, lane, quat)
        _put_three(block, P, lane, rate)
        _put_four(block, F1, lane, rotors)
        _put_three(block, AX, lane, acc)
        block[VALID * LANES + lane] = valid


@compiled(**BORROWING)
def _axes(values: AxisValues) -> Three:
    return values[0], values[1], values[2]


@compiled(**BORROWING)
def advance_rows(state: Array, commands: Array, drive: Array, body: Body, work: StepMemory) -> None:
    """Advance all vehicles by a step.

    Args:
        state: rows, (n, STATE_WIDTH), changed in place.
        commands: thrust [N], roll, pitch [rad], yaw rate [rad/s] of each, (n, 4).
        drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (n, 7).
        body: constants of the vehicles.
        work: workspace.
    """
    block, rotors = work
    stiffness, damping, inertia, lead = body.gains
    gains = AttitudeGains(_axes(stiffness), _axes(damping), _axes(inertia), lead)
    in_registers = Body(gains, body.frame, body.mass, body.decay, body.step)
    for first in range(0, state.shape[0], LANES):
        count = min(LANES, state.shape[0] - first)
        for lane in range(count):
            _load(state, commands, drive, first + lane, (block, lane))
        _step_block(block, in_registers)
        for lane in range(count):
            i = first + lane
            if block[VALID * LANES + lane] == 1.0:
                for column in range(ETA_Z):
                    state[i, column] = block[column * LANES + lane]
            else:
                command = (commands[i, 0], commands[i, 1], commands[i, 2], commands[i, 3])
                advance(state[i], command, drive[i], body, rotors)
