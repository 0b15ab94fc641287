"""Rotors: their torque, and the thrust they give where some are asked for more than they have."""

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Four, Three


@compiled(**BORROWING)
def rotor_torque(rotors: Four, lever: float, drag: float) -> Three:
    """Return the torque [N m], body, of rotor thrusts [N]; `lever` [m], `drag` [m] are of a RotorFrame."""
    f1, f2, f3, f4 = rotors
    return lever * (-f1 - f2 + f3 + f4), lever * (-f1 + f2 + f3 - f4), drag * (-f1 + f2 - f3 + f4)


@compiled(**BORROWING)
def excess_share(commanded: Four, rotor_max: Four) -> float:
    """Return a quarter of what the rotors are asked for beyond their largest thrusts [N].

    Every rotor that gives as much loses it: rotors at their limit cost the vehicle thrust, not attitude.
    """
    one, two = max(commanded[0] - rotor_max[0], 0.0), max(commanded[1] - rotor_max[1], 0.0)
    three, four = max(commanded[2] - rotor_max[2], 0.0), max(commanded[3] - rotor_max[3], 0.0)
    return 0.25 * (one + two + three + four)


@compiled(**BORROWING)
def share_given(commanded: Four, rotor_max: Four, lost: float) -> float:
    """Return the share of its thrust, less what is `lost` [N], that every rotor gives.

    It is 1 unless a rotor is asked for less than is lost: then together they give what each could by itself.
    """
    one, two, three, four = commanded
    if min(one, two, three, four) >= lost:
        return 1.0
    able = max(min(one, rotor_max[0]), 0.0) + max(min(two, rotor_max[1]), 0.0)
    able += max(min(three, rotor_max[2]), 0.0) + max(min(four, rotor_max[3]), 0.0)
    asked = max(one - lost, 0.0) + max(two - lost, 0.0) + max(three - lost, 0.0) + max(four - lost, 0.0)
    return able / asked if able < asked else 1.0
