"""Fastest approach that stops in time: the speed at which a distance may shrink.

    w(s) = p s                       0 <= s <= s_1 = B / p^2
    w(s) = sqrt(B (2 s - s_1))       beyond

Far away it decelerates by B, as a time-optimal approach does; near the end it decays with the pole p, so that
the deceleration stays below B (the square-root controller of multicopter autopilots). A shift e of a vehicle
from its reference shrinks so, e' = -w(|e|) e / |e|, by

    e'' = -p (e' + w e / |e|) - w' (e.e') e / |e|^2 - (w / |e|) (e' - (e.e') e / |e|^2)

which within s_1 is e'' = -2 p e' - p^2 e. The pole is the fastest one that a motion of bounded jerk follows:
its time constant is that of the acceleration, LAG, and a reversal of it, 2 A / J.

| symbol | name | meaning [unit] |
|---|---|---|
| p, B | law.pole, law.brake | pole [1/s], deceleration [m/s^2] |
| w, w' | speed, slope | speed of approach [m/s], its derivative by the distance [1/s] |
| A, J | acc_max, jerk_max | bounds of the motion [m/s^2], [m/s^3] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled

LAG = 0.05
"""Time constant at which the acceleration approaches the wanted one where jerk is bounded [s]."""


class ApproachLaw(NamedTuple):
    """Pole and deceleration of an approach."""

    pole: float
    brake: float


def fastest_pole(acc_max: float, jerk_max: float) -> float:
    """Return the fastest pole that a motion of bounded jerk follows [1/s]."""
    return 1.0 / (LAG + 2.0 * acc_max / jerk_max)


@compiled
def approach_speed(s: float, law: ApproachLaw) -> tuple[float, float]:
    """Return the speed of approach at a distance [m], and its slope."""
    pole, brake = law
    near = brake / (pole * pole)
    if s <= near:
        return pole * s, pole
    speed = np.sqrt(brake * (2.0 * s - near))
    return float(speed), float(brake / speed)
