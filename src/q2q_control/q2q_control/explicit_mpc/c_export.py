"""Export of the explicit law to one C99 file for the vehicle's own processor: tanhf only, no heap.

    float q2q_explicit(const float states[2][3], const float push[2][N], const float gradient[2][N]);

Returns the vertical acceleration command, the reference's included [m/s^2]. Inputs are those of
features.PairHorizon; the features are computed from them. Single precision: a Cortex-M4 has no other. The
firmware app (q2q_control.onboard) does not use it.
"""

import numpy as np

from q2q_control.explicit_mpc.explicit_law import ExplicitLaw
from q2q_control.explicit_mpc.features import (
    EDGES,
    GRADIENT_EDGES,
    GRADIENTS,
    OWN,
    SOFT,
    STAGES,
    WIDTH,
    WINDOWS,
)
from q2q_model.signals.values import Array

_BODY = """
/* Write the unbounded optimum of one axis, rolled out. */
static void roll_out(const float s[3], const float p[N], float u[N]) {
  const float *b = GAINS[0], *k_x = GAINS[1], *qux = GAINS[2], *ahead = GAINS[3], *drift = GAINS[5];
  const float (*A)[3] = &GAINS[7], (*P)[3] = &GAINS[10];
  const float quu = GAINS[6][0], effort = GAINS[6][1];
  float l0 = P[0][2] * p[N - 1], l1 = P[1][2] * p[N - 1], l2 = P[2][2] * p[N - 1];
  float e = s[0], v = s[1], a = s[2];
  for (int k = N - 1; k >= 0; --k) {
    l0 += p[k] * ahead[0];
    l1 += p[k] * ahead[1];
    l2 += p[k] * ahead[2];
    u[k] = -(b[0] * l0 + b[1] * l1 + b[2] * l2 + effort * p[k]) / quu;
    l2 = A[0][2] * l0 + A[1][2] * l1 + A[2][2] * l2 + u[k] * qux[2];
    l1 = A[0][1] * l0 + A[1][1] * l1 + u[k] * qux[1];
    l0 = A[0][0] * l0 + u[k] * qux[0];
  }
  for (int k = 0; k < N; ++k) {
    u[k] -= k_x[0] * e + k_x[1] * v + k_x[2] * a;
    e += A[0][1] * v + A[0][2] * a + b[0] * u[k] + drift[0] * p[k];
    v += A[1][2] * a + b[1] * u[k] + drift[1] * p[k];
    a = A[2][2] * a + b[2] * u[k];
  }
}

static float mean(const float *values, int from, int to) {
  float total = 0.0f;
  for (int k = from; k < to; ++k) total += values[k];
  return total / (float)(to - from);
}

static float network(float x[WIDTH]) {
  float one[H1], two[H2], total = LINEAR[WIDTH];
  for (int i = 0; i < WIDTH; ++i) {
    x[i] = (x[i] - MEAN[i]) * INVERSE_SCALE[i];
    total += LINEAR[i] * x[i];
  }
  for (int a = 0; a < H1; ++a) {
    float inside = FIRST[a][WIDTH];
    for (int i = 0; i < WIDTH; ++i) inside += FIRST[a][i] * x[i];
    one[a] = tanhf(inside);
  }
  for (int b = 0; b < H2; ++b) {
    float inside = SECOND[b][H1];
    for (int a = 0; a < H1; ++a) inside += SECOND[b][a] * one[a];
    two[b] = tanhf(inside);
  }
  for (int b = 0; b < H2; ++b) total += LAST[b] * two[b];
  return total;
}

float q2q_explicit(const float states[2][3], const float push[2][N], const float gradient[2][N]) {
  float x[WIDTH], u[N], base = 0.0f, most = 0.0f;
  for (int v = 0; v < 2; ++v) {
    roll_out(states[v], push[v], u);
    if (v == 0) base = u[0];
    for (int k = 0; k < N; ++k) {
      u[k] = u[k] > HIGH ? u[k] - HIGH : 0.0f;
      if (u[k] > most) most = u[k];
    }
    for (int i = 0; i < 3; ++i) x[v * OWN + i] = states[v][i];
    for (int w = 0; w < WINDOWS; ++w) {
      x[v * OWN + 3 + w] = mean(push[v], EDGES[w], EDGES[w + 1]);
      x[v * OWN + 3 + WINDOWS + w] = mean(u, EDGES[w], EDGES[w + 1]);
    }
    for (int w = 0; w < GRADIENTS; ++w)
      x[2 * OWN + v * GRADIENTS + w] = mean(gradient[v], GRADIENT_EDGES[w], GRADIENT_EDGES[w + 1]);
  }
  if (most > 0.0f) base += most / (most + SOFT) * network(x);
  if (!(base >= LOW)) return LOW; /* also where an input is not a number */
  return base > HIGH ? HIGH : base;
}
"""


def c_source(law: ExplicitLaw) -> str:
    """Return the law as C99 source."""
    low, high = law.bounds
    sizes = {
        "N": STAGES, "OWN": OWN, "WIDTH": WIDTH, "WINDOWS": WINDOWS, "GRADIENTS": GRADIENTS,
        "H1": law.first.shape[0], "H2": law.second.shape[0],
    }  # fmt: skip
    parts = [
        "/* Explicit law of q2q: receding horizon over height, distilled. Generated; do not edit. */",
        "#include <math.h>",
        f"enum {{ {', '.join(f'{name} = {size}' for name, size in sizes.items())} }};",
        f"static const float LOW = {_number(low)}, HIGH = {_number(high)}; /* [m/s^2] */",
        f"static const float SOFT = {_number(SOFT)}; /* [m/s^2] */",
        f"static const int EDGES[] = {{{', '.join(map(str, EDGES))}}};",
        f"static const int GRADIENT_EDGES[] = {{{', '.join(map(str, GRADIENT_EDGES))}}};",
        _array("GAINS", law.gains),
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
