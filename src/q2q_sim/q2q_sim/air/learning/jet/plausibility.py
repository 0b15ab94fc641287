"""Whether what was learned can be true: a jet pushes down, and gives no more than its source's momentum.

A source that carries its weight m g gives its jet the momentum flux m g. Another vehicle of its mass that
took all of it would be accelerated by g, and rotor disks that take what meets them get about all of it at
each gap (jet_table). A push upwards or beyond g is refused, as one of another sign or unit. Checks that are
not as expected are named.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.learning.jet import wake_rows
from q2q_sim.air.learning.jet.wake_rows import rows_under_one
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import block_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import Fitted

MOST_LIFT = 0.1
"""Largest mean push upwards under another vehicle [m/s^2]: the bias of an accelerometer. It is -0.6 to -1.2
in the public flights."""
MOMENTUM = (0.3, 2.0)
"""Expected share of its source's momentum that a jet gives to rotor disks of a Crazyflie 2.x [-]: 0.5 to 1.0
in the public flights; propellers of 55 mm have 1.5 times the area."""
LATERAL = 0.2
"""Largest share of the push on the axis that the lateral one may have to be negligible: 0.04 in dc19."""
TOGETHER = (0.3, 1.2)
"""Expected push of two wakes over the sum of both [-]: 0.74 in dc21."""
COLUMNS = "the measured push: the column faz_est [N], upwards, or imu [m/s^2], z up, and command [N]"


def reject_lift(records: Sequence[AirRecord]) -> None:
    """Raise ValueError if vehicles under exactly one other are pushed up."""
    parts = [part for part in rows_under_one(records) if part.exposed.any()]
    if not parts:
        return
    exposed = np.concatenate([part.exposed for part in parts])
    y = np.concatenate([part.y for part in parts])[exposed]
    sums = block_sums(np.stack([np.ones(y.size), y], axis=1), wake_rows.row_blocks(parts)[exposed])
    means = estimate_spread(
        lambda weight: (weight @ sums)[1:] / max(float((weight @ sums)[0]), 1.0), len(sums)
    )
    lift, low = float(means.value[0]), float(means.low[0])
    if lift > MOST_LIFT and not low <= 0.0:
        raise ValueError(
            f"vehicles under another are pushed up by {lift:.2f} m/s^2 on average, but downwash pushes down: "
            f"check the sign of {COLUMNS}"
        )


def reject_excess(jet: JetTerm) -> None:
    """Raise ValueError for a push of more than g."""
    most = float(jet.push_mps2.max())
    if most > GRAVITY:
        raise ValueError(
            f"the push under another vehicle is up to {most:.3g} m/s^2, but all momentum of a source of the "
            f"same weight gives {GRAVITY:.2f}: check the unit of {COLUMNS}"
        )


def doubts(values: Sequence[Fitted], checks: Sequence[Fitted]) -> tuple[str, ...]:
    """Return a sentence on each check that is not as expected."""
    known = {one.path: one.value for one in (*values, *checks)}
    found = []
    momentum = known.get("momentum of one jet")
    if momentum is not None and not MOMENTUM[0] <= momentum <= MOMENTUM[1]:
        found.append(
            f"one jet gives rotor disks {momentum:.2g} of its source's momentum, expected "
            f"{_range(MOMENTUM)}: check the unit of {COLUMNS}"
        )
    lateral, push = known.get("largest radial mean"), known.get("jet.push_mps2")
    if lateral is not None and push is not None and abs(lateral) > LATERAL * abs(push):
        found.append(
            f"the lateral push, {lateral:.2g} m/s^2, is more than {LATERAL:.0%} of the push on the axis, "
            "which no air model includes: check the signs of x, y, roll and pitch of imu and mocap"
        )
    together = known.get("two wakes over their sum")
    if together is not None and not TOGETHER[0] <= together <= TOGETHER[1]:
        found.append(
            f"two wakes together have {together:.2g} of their sum, expected {_range(TOGETHER)}: fly longer "
            "under two vehicles, or leave out the absorption (--air-without absorption)"
        )
    return tuple(found)


def _range(bounds: tuple[float, float]) -> str:
    return f"{bounds[0]:g} to {bounds[1]:g}"
