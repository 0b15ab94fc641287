"""Write the explicit law as one C99 file for the vehicle's own processor: no library but tanhf, no heap.

    float q2q_explicit(const float x[Q2Q_EXPLICIT_INPUTS]);    vertical acceleration command [m/s^2]

Inputs are those of q2q_control.explicit.features, in its order. Single precision: a Cortex-M4 has no other.
"""

import numpy as np

from q2q_control.explicit.law import ExplicitLaw
from q2q_model.signals import Array

_BODY = """
float q2q_explicit(const float x[Q2Q_EXPLICIT_INPUTS]) {
  float z[Q2Q_EXPLICIT_INPUTS], one[H1], two[H2];
  float u = LINEAR[Q2Q_EXPLICIT_INPUTS];
  for (int i = 0; i < Q2Q_EXPLICIT_INPUTS; ++i) {
    u += LINEAR[i] * x[i];
    z[i] = (x[i] - MEAN[i]) * INVERSE_SCALE[i];
  }
  for (int a = 0; a < H1; ++a) {
    float inside = FIRST[a][Q2Q_EXPLICIT_INPUTS];
    for (int i = 0; i < Q2Q_EXPLICIT_INPUTS; ++i) inside += FIRST[a][i] * z[i];
    one[a] = tanhf(inside);
  }
  for (int b = 0; b < H2; ++b) {
    float inside = SECOND[b][H1];
    for (int a = 0; a < H1; ++a) inside += SECOND[b][a] * one[a];
    two[b] = tanhf(inside);
  }
  for (int b = 0; b < H2; ++b) u += LAST[b] * two[b];
  u += LAST[H2];
  if (!(u >= LOW)) return LOW; /* also where an input is not a number */
  return u > HIGH ? HIGH : u;
}
"""


def c_source(law: ExplicitLaw) -> str:
    """Return the law as C99 source."""
    low, high = law.bounds
    parts = [
        "/* Explicit law of q2q: receding horizon over height, distilled. Generated; do not edit. */",
        "#include <math.h>",
        f"#define Q2Q_EXPLICIT_INPUTS {law.mean.size}",
        f"enum {{ H1 = {law.first.shape[0]}, H2 = {law.second.shape[0]} }};",
        f"static const float LOW = {_number(low)}, HIGH = {_number(high)}; /* [m/s^2] */",
        _array("MEAN", law.mean),
        _array("INVERSE_SCALE", 1.0 / law.scale),
        _array("LINEAR", law.linear),
        _array("FIRST", law.first),
        _array("SECOND", law.second),
        _array("LAST", law.last),
    ]
    return "\n".join(parts) + _BODY


def _array(name: str, values: Array) -> str:
    shape = "".join(f"[{size}]" for size in values.shape)
    return f"static const float {name}{shape} = {_braced(values)};"


def _braced(values: Array) -> str:
    if values.ndim == 1:
        return "{" + ", ".join(_number(value) for value in values) + "}"
    return "{" + ",\n  ".join(_braced(row) for row in values) + "}"


def _number(value: float) -> str:
    return f"{np.float32(value):.9e}f"
