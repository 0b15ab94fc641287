"""Conversions and kinematics of quaternions and Euler angles.

Quaternions are x y z w, body to world, of unit length; q and -q are the same attitude. Euler angles are
roll phi, pitch theta, yaw psi in the order Z-Y-X: R(q) = Rz(psi) Ry(theta) Rx(phi). Every function takes
leading batch axes that broadcast. Source: Diebel, Representing Attitude, Stanford 2006, sections 5.6, 6.

    v_world = q v_body q*                       rotate
    q' = q (w_body, 0) / 2                      integrate_quat (exact for a constant w)
    w_body = log(q0* q1) / dt                   ang_vel_between (likewise)
    exp(r) = (r sin(|r|/2)/|r|, cos(|r|/2))     quat_from_vector

| symbol | name | meaning [unit] |
|---|---|---|
| q | quat | orientation x y z w, body to world |
| phi theta psi | roll pitch yaw | [rad] |
| w | ang_vel_body | angular velocity, body [rad/s] |
| r | vector | axis times angle [rad] |
"""

import numpy as np
from numpy.typing import ArrayLike

from q2q_model.signals.values import Array

UP = np.array([0.0, 0.0, 1.0])
"""Vertical of the world, and body z of a level vehicle, (3,)."""
_SMALL_ANGLE = 1e-8
"""Below this angle sin(x)/x rounds to 1 [rad]."""
_TINY = 1e-150
"""Lower bound of the sine in sin(x)/x; its square does not underflow."""


def _bilinear(rows: int, columns: int, terms: str) -> Array:
    """Return B such that a b = (a_i b_j, flat) B; `terms` lists signed index pairs per column, as "+03-12".

    For few vehicles one matrix product costs a third of the written-out products.
    """
    table = np.zeros((rows * rows, columns))
    for column, text in enumerate(terms.split()):
        for sign, i, j in zip(text[0::3], text[1::3], text[2::3], strict=True):
            table[int(i) * rows + int(j), column] = -1.0 if sign == "-" else 1.0
    return table


_CROSS = _bilinear(3, 3, "+12-21 +20-02 +01-10")
"""a x b."""
_QUAT_PRODUCT = _bilinear(4, 4, "+30+03+12-21 +31+13+20-02 +32+23+01-10 +33-00-11-22")
"""a b, indices 0 1 2 3 = x y z w."""
_QUAT_BETWEEN = _QUAT_PRODUCT * np.array([-1.0] * 12 + [1.0] * 4)[:, None]
"""a* b."""


def identity_quat(shape: tuple[int, ...] = ()) -> Array:
    """Return level attitudes, nose along world x, (*shape, 4)."""
    quat = np.zeros((*shape, 4))
    quat[..., 3] = 1.0
    return quat


def level_where_unknown(quat: Array) -> Array:
    """Return quaternions (..., 4), level where they are not finite."""
    return np.where(np.isfinite(quat).all(axis=-1, keepdims=True), quat, identity_quat())


def quat_from_euler(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Array:
    """Return the quaternion of Euler angles [rad] Z-Y-X, (..., 4), with the sign of cos(angle/2)."""
    half_roll, half_pitch, half_yaw = (
        0.5 * np.asarray(angle, dtype=np.float64) for angle in (roll, pitch, yaw)
    )
    cr, sr = np.cos(half_roll), np.sin(half_roll)
    cp, sp = np.cos(half_pitch), np.sin(half_pitch)
    cy, sy = np.cos(half_yaw), np.sin(half_yaw)
    return np.stack(
        np.broadcast_arrays(
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ),
        axis=-1,
    )


def euler_from_quat(quat: Array) -> Array:
    """Return roll, pitch, yaw [rad], (..., 3), of `quat` (..., 4).

    Roll and yaw lie in (-pi, pi], pitch in [-pi/2, pi/2]. At pitch = +-pi/2 only roll -+ yaw is defined;
    roll is therefore that of the attitude without its yaw, which is (sin, cos)(roll/2) cos(pitch/2) in x, w.
    The lengths of (w - y, x + z) and (w + y, x - z) are cos(pitch/2) -+ sin(pitch/2).
    """
    x, y, z, w = _parts(quat)
    yaw = yaw_from_quat(quat)
    cy, sy = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    sr, cr = cy * x + sy * y, cy * w + sy * z
    roll = np.arctan2(2.0 * sr * cr + 0.0, cr * cr - sr * sr)  # + 0.0 makes -0 positive: pi, not -pi
    pitch = np.arctan2(2.0 * (w * y - x * z), np.hypot(w - y, x + z) * np.hypot(w + y, x - z))
    return np.stack([roll, pitch, yaw], axis=-1)


def yaw_from_quat(quat: Array) -> Array:
    """Return yaw psi [rad], (...,), of `quat` (..., 4)."""
    x, y, z, w = _parts(quat)
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def matrix_from_quat(quat: Array) -> Array:
    """Return the rotation matrix, body to world, (..., 3, 3); its columns are the body's axes."""
    x, y, z, w = _parts(quat)
    entries = [
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    ]  # fmt: skip
    return np.stack(entries, axis=-1).reshape(*quat.shape[:-1], 3, 3)


def rotate(quat: Array, vector_body: Array) -> Array:
    """Return vectors of the body frame in the world frame, (..., 3)."""
    axis, w = quat[..., :3], quat[..., 3:]
    twice = 2.0 * _cross(axis, vector_body)
    return np.asarray(vector_body + w * twice + _cross(axis, twice))


def rotate_inverse(quat: Array, vector: Array) -> Array:
    """Return vectors of the world frame in the body frame, (..., 3)."""
    return rotate(quat_conjugate(quat), vector)


def quat_conjugate(quat: Array) -> Array:
    """Return the inverse rotation, (..., 4)."""
    return np.asarray(quat * np.array([-1.0, -1.0, -1.0, 1.0]))


def quat_multiply(left: Array, right: Array) -> Array:
    """Return the rotation `right` followed by `left`, (..., 4): R(left right) = R(left) R(right)."""
    pairs = left[..., :, None] * right[..., None, :]
    return np.asarray(pairs.reshape(*pairs.shape[:-2], 16) @ _QUAT_PRODUCT)


def quat_between(before: Array, after: Array) -> Array:
    """Return the rotation before* after in body axes, (..., 4); its w is the cosine of half the angle."""
    pairs = before[..., :, None] * after[..., None, :]
    return np.asarray(pairs.reshape(*pairs.shape[:-2], 16) @ _QUAT_BETWEEN)


def normalised(quat: Array) -> Array:
    """Return `quat` scaled to unit length, (..., 4); a zero quaternion becomes NaN."""
    length = np.sqrt(np.sum(quat * quat, axis=-1, keepdims=True))
    return np.asarray(quat / np.where(length > 0.0, length, np.nan))


def continuous_quats(quat: Array) -> Array:
    """Return quaternions (T, 4) with signs that do not jump from row to row, to be interpolated."""
    flips = np.where((quat[1:] * quat[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    return np.asarray(quat * np.concatenate([[1.0], np.cumprod(flips)])[:, None])


def quat_from_vector(vector: Array) -> Array:
    """Return exp of a rotation vector [rad], (..., 3) -> (..., 4)."""
    angle = np.sqrt(np.sum(vector * vector, axis=-1, keepdims=True))
    small = angle < _SMALL_ANGLE
    scale = np.where(small, 0.5, np.sin(0.5 * angle) / np.where(small, 1.0, angle))
    return np.concatenate([vector * scale, np.cos(0.5 * angle)], axis=-1)


def vector_from_quat(quat: Array) -> Array:
    """Return the shortest rotation vector (log) [rad], (..., 4) -> (..., 3); its length is at most pi."""
    near = quat * np.copysign(1.0, quat[..., 3:])
    axis = near[..., :3]
    sine = np.maximum(np.sqrt((axis * axis).sum(axis=-1, keepdims=True)), _TINY)
    return np.asarray(axis * (2.0 * np.arctan2(sine, near[..., 3:]) / sine))


def integrate_quat(quat: Array, ang_vel_body: Array, dt: float) -> Array:
    """Return the attitude after `dt` [s] at constant `ang_vel_body` [rad/s], exact, (..., 4)."""
    return quat_multiply(quat, quat_from_vector(ang_vel_body * dt))


def ang_vel_between(quat_before: Array, quat_after: Array, dt: ArrayLike) -> Array:
    """Return the constant body rate [rad/s], (..., 3), that leads from one attitude to the next in `dt` [s].

    `dt` is a number or (...,). The shorter rotation is assumed, which holds below pi / dt.
    """
    step = vector_from_quat(quat_between(quat_before, quat_after))
    return np.asarray(step / np.asarray(dt, dtype=np.float64)[..., None])


def _parts(quat: Array) -> tuple[Array, Array, Array, Array]:
    return quat[..., 0], quat[..., 1], quat[..., 2], quat[..., 3]


def _cross(a: Array, b: Array) -> Array:
    pairs = a[..., :, None] * b[..., None, :]
    return np.asarray(pairs.reshape(*pairs.shape[:-2], 9) @ _CROSS)
