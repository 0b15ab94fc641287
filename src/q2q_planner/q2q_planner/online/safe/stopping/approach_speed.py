"""Fastest approach that stops in time: the speed at which a distance may shrink.

    w(s) = p s                       0 <= s <= s_1 = B / p^2
    w(s) = sqrt(B (2 s - s_1))       beyond

Far away it decelerates by B, as a time-optimal approach does; near the end it decays with the pole p, so that
the deceleration stays below B (the square-root controller of multicopter autopilots). A shift e of a vehicle
from its reference shrinks so, e' = -w(|e|) e / |e|, by

    e'' = -p (e' + w e / |e|) - w' (e.e') e / |e|^2 - (w / |e|) (e' - (e.e') e / |e|^2)

which within s_1 is e'' = -2 p e' - p^2 e. Where jerk is bounded, the acceleration lags by T = max(LAG, hold).
From p T = 2 on the approach is unstable, and it overshoots well before, so p is at most 0.4 / T. It also
leaves time for a reversal of the acceleration: p is at most 1 / (T + 2 acc_max / jerk_max), which is 4/s at
2 m/s^2 and 20 m/s^3 (`followed_pole`). Vehicles follow slow poles more closely.

| symbol | name | meaning [unit] |
|---|---|---|
| p, B | law.pole, law.brake | pole [1/s], deceleration [m/s^2] |
| w, w' | speed, slope | speed of approach [m/s], its derivative by the distance [1/s] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled

LAG = 0.05
"""Time constant of the acceleration towards the desired one where jerk is bounded [s]; `hold` if longer."""
FOLLOWED = 0.4
"""Largest product of pole and lag without overshoot, in simulated steps of 0.3 to 5 m at regular, slow and
lost ticks; at 0.5 some overshoot."""


class ApproachLaw(NamedTuple):
    """Pole and deceleration of an approach."""

    pole: float
    """[1/s]."""
    brake: float
    """[m/s^2]."""


def followed_pole(pole: float, lag: float, reversal: float) -> float:
    """Return a pole [1/s], or the fastest one that an acceleration follows without overshoot.

    It lags by `lag` [s], and takes `reversal` [s] from its largest value to the opposite one.
    """
    return min(pole, FOLLOWED / lag, 1.0 / (lag + reversal))


@compiled
def approach_speed(s: float, law: ApproachLaw) -> tuple[float, float]:
    """Return the speed of approach w [m/s] at a distance s [m], and its slope w' [1/s]."""
    pole, brake = law
    near = brake / (pole * pole)
    if s <= near:
        return pole * s, pole
    speed = np.sqrt(brake * (2.0 * s - near))
    return float(speed), float(brake / speed)
