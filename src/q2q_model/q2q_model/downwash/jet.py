"""The downwash as a round jet with a few physical parameters.

    eta_lower = -A decay(gap) exp(-r^2 / (2 s(gap)^2)) (1 + c v_i,z tau / gap),   s(gap) = s0 + ks gap
    eta_upper = -ratio eta_lower
    decay = ((z0 + gap_ref) / (z0 + gap))^2      "power": free round jet, speed ~ 1/distance
          = exp(-beta (gap - gap_ref))           "exponential": best fit to real flights
    tau = gap / travel_speed                     transport delay

    r = |rel_xy + c (k v_j,xy tau - gap b_xy / b_z)|  distance to the jet's axis at the vehicle's height

rel_pos is r_j(t - tau) - r_i(t). The air leaves along -b, the source's negative body z. It keeps the source's
velocity v_j and the slope of the jet on its way down (c = 1), or falls straight down (c = 0), as in the
paper. A vehicle climbing at v_i,z meets air that descends at travel_speed with the sum of both speeds.

Real flights support c = 1: fitted freely, the share of slope kept is 0.997 (family dc21) and 1.13 (dc19), and
explains more than a third of the residual of a straight fall. Of the source's velocity, the still air leaves
k = 0.6 on average on the way down (fitted to dc21; dc19 0.77).

eta acts along z only. `PAPER_LAW` is the synthetic downwash that reproduces the paper's Table 6;
`MEASURED_LAW` is the three-parameter law with delay fitted to two Crazyflie 2.1 (flights recorded for
Neural-Swarm2, T-RO 2021) that flew without feed-forward.

| symbol | name | meaning [unit] |
|---|---|---|
| A | strength | downward acceleration on the axis, gap_ref below the source [m/s^2] |
| gap | | height difference, smoothed at zero [m] |
| gap_ref | reference_gap | height difference at which A holds [m] |
| z0 | virtual_origin | height of the jet's virtual origin above its source [m] |
| beta | decay_rate | [1/m] |
| s0, ks | width, spread | radial standard deviation at the source [m] and its growth [m/m] |
| c | carried | share of the source's velocity and slope that the air keeps [-]; 0 ignores motion |
| k | velocity_share | share of the kept velocity that the still air leaves on the way [-] |

`loading` and `absorption` act between several sources (q2q_model.downwash.source_strength).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from q2q_model.downwash.interaction_model import EDGE, PairMotion, Reach
from q2q_model.downwash.jet_kernel import STEEPEST, JetLaw, JetPairs, evaluate_pairs
from q2q_model.signals.values import Array
from q2q_model.tunable import check_bounds, tunable


@dataclass(frozen=True, slots=True)
class Jet:
    """Parametric jet; an InteractionModel."""

    strength: float = tunable(
        0.392, "downward acceleration on the axis at the reference gap", unit="m/s^2", low=-20, high=20
    )
    reference_gap: float = tunable(0.5, "height difference at which strength holds", unit="m", low=0, high=5)
    decay: str = tunable("power", "decay of the downwash with the gap", choices=("power", "exponential"))
    virtual_origin: float = tunable(
        0.33, "virtual origin of the jet above its source (power)", unit="m", low=0.01, high=10
    )
    decay_rate: float = tunable(0.95, "decay rate (exponential)", unit="1/m", low=-5, high=20)
    width: float = tunable(0.06, "radial standard deviation at the source", unit="m", low=0.002, high=1)
    spread: float = tunable(0.08, "growth of the width with the gap", unit="m/m", low=0, high=1)
    upper_ratio: float = tunable(
        0.2, "upward acceleration of the upper vehicle over the lower one's", low=-1, high=1
    )
    travel_speed: float = tunable(
        0.0, "descent speed of the air; 0 for no delay", unit="m/s", low=0, high=1e3
    )
    carried: float = tunable(
        0.0, "share of the source's velocity and slope that the air keeps", low=0, high=1
    )
    relative_std: float = tunable(0.0, "growth of the standard deviation with the downwash", low=0, high=10)
    std_floor: float = tunable(
        0.0, "standard deviation outside the downwash; both 0: unknown", unit="m/s^2", low=0, high=10
    )
    range: float = tunable(3.0, "largest gap with downwash", unit="m", low=0.1, high=10)
    velocity_share: float = tunable(
        1.0, "share of the kept velocity that the still air leaves", low=0, high=1
    )
    loading: float = tunable(
        0.0, "growth of a source's downwash over that of its thrust, relative to hover", low=0, high=2
    )
    absorption: float = tunable(
        0.0,
        "share of a jet that a vehicle in it takes away, over its acceleration by it in g",
        low=0,
        high=4,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    @property
    def reach(self) -> Reach:
        """Return the range, and where the widest Gaussian has fallen to 1e-4 at the steepest slope."""
        aside = EDGE * (self.width + self.spread * self.range) + self.carried * STEEPEST * self.range
        return Reach(horizontal=aside, vertical=self.range)

    @property
    def max_delay(self) -> float:
        """Return the delay over the whole range [s]."""
        return self.range / self.travel_speed if self.travel_speed > 0.0 else 0.0

    def delay(self, rel_pos: Array) -> Array:
        """Return tau [s], (...,); zero for a source below."""
        if self.travel_speed == 0.0:
            return np.zeros(rel_pos.shape[:-1])
        fall = np.minimum(np.maximum(rel_pos[..., 2], 0.0), self.range)  # np.clip takes three times as long
        return np.asarray(fall / self.travel_speed)

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return eta [m/s^2], world, (..., 3)."""
        return self._evaluate(rel_pos, motion)[1]

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return one standard deviation [m/s^2], (..., 3): affine in the downwash along z, else NaN."""
        std = np.full(rel_pos.shape, np.nan)
        if self.relative_std + self.std_floor > 0.0:
            push = np.abs(self.acceleration(rel_pos, motion)[..., 2])
            std[..., 2] = self.std_floor + self.relative_std * push
        return std

    def push(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return the downward acceleration of a lower vehicle [m/s^2], (...,), before roles are blended."""
        return self._evaluate(rel_pos, motion)[0]

    def _evaluate(self, rel_pos: Array, motion: PairMotion) -> tuple[Array, Array]:
        """Return the unblended downward acceleration (...,) and eta (..., 3)."""
        shape = rel_pos.shape
        push, eta = np.empty(shape[:-1]), np.empty(shape)
        moving = (motion.source_vel, motion.source_axis, motion.vel)
        own = shape[1:] if all(part.shape == shape[1:] for part in moving) else shape
        pairs = JetPairs(_as_pairs(rel_pos, shape), *(_as_pairs(part, own) for part in moving))
        evaluate_pairs(pairs, jet_law(self), push.reshape(-1), eta.reshape(-1, 3))
        return push, eta


def _as_pairs(part: Array, shape: tuple[int, ...]) -> Array:
    """Return (..., 3) as contiguous rows (p, 3), broadcast to `shape`."""
    if part.shape != shape:
        part = np.broadcast_to(part, shape)
    return np.ascontiguousarray(part, dtype=np.float64).reshape(-1, 3)


@lru_cache(maxsize=64)
def jet_law(jet: Jet) -> JetLaw:
    """Return the parameters of a jet for compiled code."""
    shape = jet.strength, jet.reference_gap, jet.decay == "power", jet.virtual_origin, jet.decay_rate
    width = jet.width, jet.spread, jet.upper_ratio
    return JetLaw(*shape, *width, jet.travel_speed, jet.carried, jet.velocity_share, jet.range)


PAPER_LAW = Jet()
"""Law that reproduces the paper's Table 6 (A, z0, s0, ks and the ratio solved from its values)."""

MEASURED_LAW = Jet(
    strength=2.5,
    reference_gap=0.4,
    decay="exponential",
    decay_rate=0.95,
    width=0.054,
    spread=0.0,
    upper_ratio=0.02,
    travel_speed=7.5,
    range=1.2,
)
"""Law of two Crazyflie 2.1 flown without feed-forward, fitted where dz is 0.2 to 0.7 m."""

MOVING_LAW = Jet(
    strength=2.88,
    reference_gap=0.4,
    decay="exponential",
    decay_rate=1.32,
    width=0.033,
    spread=0.050,
    upper_ratio=0.007,
    travel_speed=2.59,
    carried=1.0,
    relative_std=0.082,
    std_floor=0.40,
    range=1.5,
)
"""Law of the same flights for a jet that moves with its source: R2 0.90, and 0.865 on held-out flights."""
