"""Zone of a plan with risk: where two vehicles may touch, or one meets more downwash than its thrust holds.

With probability 1 - alpha, for each vehicle and flight,

    |r_i - r_i,ref| <= tube at all times                                       (alpha_tube)
    |eta| + r <= hold at the worst moment of a pass,  r ~ N(0, sigma(eta)^2)   (alpha - alpha_tube)

if the references keep dr_ij = r_i,ref - r_j,ref out of

    Z = conv( { |dr| <= touch } u { max(|eta(dr)|, |eta(-dr)|) >= push } ) + tube_i - tube_j
    push + z sigma(push) = hold,    z = Phi^-1(1 - alpha + alpha_tube)

which a certificate proves for every t. sigma = floor + slope |eta| is the size of the model's residual, so
that push is explicit. The risks of one vehicle add up (Boole); any of n vehicles fails with probability
n alpha at most, however their errors depend on each other, and a pair touches only if one of its two fails.

Conditions: flights like those that the tube was learned from; the downwash of a level source at rest, one
source at a time; a normal residual, at one instant: it is drawn again every `time_s`, and its effect on the
position is part of the tube.

| symbol | name | meaning [unit] |
|---|---|---|
| alpha | alpha | risk of one vehicle in one flight [-] |
| hold | hold | downwash that the thrust holds in addition to the plan's accelerations [m/s^2] |
| touch | touch | distance of centres at which two vehicles touch [m] |
| push | largest_push | largest mean downwash allowed [m/s^2] |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash import level_set
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CONTACT
from q2q_planner.offline.certificate.convex_zone import ConvexZone, zone_around, zone_by_support


@dataclass(frozen=True, slots=True)
class RiskTube:
    """Distance from its reference that a vehicle keeps for a whole flight, with probability 1 - risk."""

    horizontal: float
    """[m]"""
    vertical: float
    """[m]"""
    risk: float
    """[-]"""

    def __post_init__(self) -> None:
        """Raise ValueError if a number is out of bounds."""
        for name in ("horizontal", "vertical", "risk"):
            value, most = getattr(self, name), 0.5 if name == "risk" else 2.0
            if not 0.0 <= value <= most:
                raise ValueError(f"tube: {name} = {value:g}; must be in [0, {most:g}]")


@dataclass(frozen=True, slots=True)
class RiskParams:
    """Risk of a vehicle, its thrust margin, and the tube of a plan."""

    alpha: float
    """Risk of one vehicle in one flight [-]."""
    hold: float
    """Downwash that the thrust holds in addition to the plan's accelerations [m/s^2]."""
    tube: RiskTube
    touch: float = CONTACT
    """Distance at which two vehicles touch [m]."""

    def __post_init__(self) -> None:
        """Raise ValueError if a number is out of bounds, or if the tube alone takes the whole risk."""
        for name, value, most in (
            ("risk", self.alpha, 0.5),
            ("hold", self.hold, 100.0),
            ("touch", self.touch, 5.0),
        ):
            if not 0.0 < value <= most:
                raise ValueError(f"{name} = {value:g}; must be in (0, {most:g}]")
        if not self.tube.risk < self.alpha:
            taken = f"the tube alone is left with probability {self.tube.risk:g}"
            raise ValueError(f"risk = {self.alpha:g}: {taken}; allow more risk, or give a tube with less")


def largest_push(params: RiskParams, residual: ResidualProcess) -> float:
    """Return the mean downwash that, with its residual, stays below `hold` [m/s^2].

    Raises:
        ValueError: the residual alone exceeds it.
    """
    from scipy.stats import norm  # half a second to import

    z = float(norm.isf(params.alpha - params.tube.risk))
    push = (params.hold - z * residual.floor) / (1.0 + z * residual.slope)
    if not push > 0.0:
        still = f"{z:.2f} deviations of the residual without downwash are {z * residual.floor:.2f} m/s^2"
        raise ValueError(f"hold = {params.hold:.2f} m/s^2: {still}; allow more thrust or more risk")
    return push


def risk_zone(model: InteractionModel, params: RiskParams, residual: ResidualProcess) -> ConvexZone:
    """Return Z; raise as `largest_push`."""
    push = largest_push(params, residual)
    grown = 2.0 * np.array([params.tube.horizontal, params.tube.vertical])
    strong = np.zeros((1, 2))  # (radius, height) of corners
    if push < level_set.peak_downwash(model):
        strong = zone_around(level_set.level_set(model, push)).profile + 0.5 * level_set.STEP

    def support(normal: Array) -> Array:
        core = np.maximum(params.touch, (normal @ strong.T).max(axis=-1))
        return np.asarray(core + normal @ grown)

    return zone_by_support(support, np.maximum(params.touch, strong.max(axis=0)) + grown)
