"""Unit quaternions in 32 bits: the three smallest of their parts, 10 bits each.

Source: firmware: modules/interface/quatcompress.h. Two bits name the largest part, which is made positive (q
and -q are one attitude) and follows from the length; each other part has a sign and 9 bits of |part| sqrt 2.
Each of these errs by at most 1 / (2 * 511 * sqrt 2) = 0.0007, the largest part by their sum, 0.0021.
"""

import math

from q2q_model.signals.values import Four

_TOP = (1 << 9) - 1
"""Largest number of 9 bits."""


def compress_quat(quat: Four) -> int:
    """Return the 32 bits of a unit quaternion x y z w."""
    largest = max(range(4), key=lambda k: abs(quat[k]))
    sign = -1.0 if quat[largest] < 0.0 else 1.0
    bits = largest
    for k in range(4):
        if k != largest:
            part = sign * quat[k]
            size = min(int(_TOP * abs(part) * math.sqrt(2.0) + 0.5), _TOP)
            bits = bits << 10 | (part < 0.0) << 9 | size
    return bits


def decompress_quat(bits: int) -> Four:
    """Return the quaternion x y z w of 32 bits."""
    largest = bits >> 30
    parts = [0.0] * 4
    for k in reversed(range(4)):
        if k != largest:
            size = (bits & _TOP) / _TOP / math.sqrt(2.0)
            parts[k] = -size if bits >> 9 & 1 else size
            bits >>= 10
    parts[largest] = math.sqrt(max(1.0 - sum(part * part for part in parts), 0.0))
    return parts[0], parts[1], parts[2], parts[3]
