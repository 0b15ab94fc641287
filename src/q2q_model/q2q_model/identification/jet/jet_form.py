"""Structure of a jet that is fitted, and its free parameters as a vector.

Free parameters are strength, decay, width, spread, upper ratio, and slowness 1 / travel_speed; of a loaded
form also the share of velocity left by the still air and, from flights of three or more, loading and
absorption. The form of the decay and the share of velocity and slope that the air keeps are given.

Pairs show how a source's thrust varies in manoeuvres, but not what a vehicle between two others takes from
the jet above it. Loading without this absorption predicts triples worse than no loading does:

| fitted to the pairs of | R2 on | with loading | without |
|---|---|---|---|
| dc21 | triples of dc21 | 0.790 | 0.827 |
| dc21 | pairs of dc19 | 0.889 | 0.887 |
| dc19 | triples of dc21 | 0.830 | 0.842 |
| dc19 | pairs of dc21 | 0.908 | 0.902 |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.signals.values import Array

REFERENCE_GAP = 0.4
"""Height difference at which a fitted strength holds [m]: amid the gaps of recorded flights, 0.2 to 0.7 m."""
RANGE = 1.5
"""Range of a fitted jet [m]: beyond the gaps at which pushes are exposed, up to 1.2 m."""
FASTEST = 500.0
"""Travel speed above which delay is negligible [m/s]: a tenth of a tick over half a metre."""


@dataclass(frozen=True, slots=True)
class JetForm:
    """Structure of a jet, chosen before fitting."""

    decay: str = "exponential"
    carried: float = 1.0
    delayed: bool = True
    spreading: bool = True
    loaded: bool = False
    """Whether velocity share and, from flights of three or more, loading and absorption are fitted."""


class FreeParameter(NamedTuple):
    """First value of a parameter, its bounds, the change that counts as one, and the derivative's step."""

    start: float
    low: float
    high: float
    scale: float
    step: float


STEP = 1e-4
"""Step of the derivative by a parameter on which the downwash depends smoothly, in units of the parameter."""
SLOWNESS_STEP = 0.1
"""Step of the derivative by slowness [s/m], 40 ms of delay over 0.4 m. The noise of recorded positions over
this time has to be small beside the speeds of vehicles: over a tick, 1 mm is 0.14 m/s, and the fit stops
where it starts."""

FREE_PARAMETERS = {
    "strength": FreeParameter(1.5, -5.0, 15.0, 1.0, STEP),
    "decay_rate": FreeParameter(1.0, -2.0, 10.0, 1.0, STEP),
    "virtual_origin": FreeParameter(0.5, 0.02, 5.0, 0.3, STEP),
    "width": FreeParameter(0.07, 0.015, 0.4, 0.05, STEP),
    "spread": FreeParameter(0.05, 0.0, 0.4, 0.1, STEP),
    "upper_ratio": FreeParameter(0.02, -0.8, 0.8, 0.2, STEP),
    "slowness": FreeParameter(0.15, 0.0, 0.8, 0.2, SLOWNESS_STEP),
    "velocity_share": FreeParameter(0.8, 0.0, 1.0, 0.3, STEP),
    "loading": FreeParameter(0.3, 0.0, 2.0, 0.5, STEP),
    "absorption": FreeParameter(0.5, 0.0, 4.0, 1.0, STEP),
}
"""In the units of a Jet; slowness in s/m."""


def free_names(form: JetForm, *, stacked: bool) -> list[str]:
    """Return the names of the parameters to fit; `stacked`: some vehicle may be between two others."""
    decay = "decay_rate" if form.decay == "exponential" else "virtual_origin"
    return [
        *("strength", "width", "upper_ratio", decay),
        *(["spread"] if form.spreading else []),
        *(["slowness"] if form.delayed else []),
        *(["velocity_share"] if form.loaded else []),
        *(["loading", "absorption"] if form.loaded and stacked else []),
    ]


def jet_of_values(form: JetForm, names: Sequence[str], x: Array) -> Jet:
    """Return the jet of a form with these values of its free parameters, (p,)."""
    values = dict(zip(names, (float(v) for v in x), strict=True))
    slowness = values.pop("slowness", 0.0)
    return Jet(
        reference_gap=REFERENCE_GAP,
        decay=form.decay,
        carried=form.carried,
        travel_speed=1.0 / slowness if slowness * FASTEST > 1.0 else 0.0,
        range=RANGE,
        **({"spread": 0.0} | values),
    )


def values_of_jet(jet: Jet, names: Sequence[str]) -> Array:
    """Return a jet's fitted parameters, (p,); the inverse of `jet_of_values`."""
    slowness = 1.0 / jet.travel_speed if jet.travel_speed > 0.0 else 0.0
    return np.array([slowness if name == "slowness" else getattr(jet, name) for name in names])
