"""Tests of what is reported of setpoints that a replanner cannot repair."""

import numpy as np

from q2q_model.signals.values import SetpointStatus, SwarmSetpoint
from q2q_planner.online.setpoint_warnings import SETTLED_S, SetpointWarnings

NAMES = ("cf1", "cf2")


def setpoint(t: float, *, broken: bool = False, nan: bool = False) -> SwarmSetpoint:
    pos, status = np.zeros((2, 3)), np.zeros(2, np.uint8)
    status[:] = SetpointStatus.SHIFTED
    if broken:
        status[1] = SetpointStatus.PROMISE_BROKEN
    if nan:
        pos[0, 2] = np.nan
    zero = np.zeros((2, 3))
    return SwarmSetpoint(t, NAMES, pos, zero, zero, np.zeros(2), np.zeros(2), status)


def test_a_warning_is_reported_once_until_it_has_been_over_for_a_while() -> None:
    warnings = SetpointWarnings()
    lines = [
        warnings.take(setpoint(0.01 * k, broken=100 <= k < 200 or k == 400)) for k in range(int(1e2 * 16))
    ]
    assert {k: line for k, line in enumerate(lines) if line} == {
        100: "promise broken: cf2",
        401 + round(100 * SETTLED_S): "setpoints have been sound for 10 s",
    }
    assert warnings.take(setpoint(30.0, broken=True)) == "promise broken: cf2"


def test_a_clock_that_is_set_back_makes_no_time_of_sound_setpoints() -> None:
    """Sound from 8 s on, set back to 2 s at 12 s: 4 s of them, and whatever follows."""
    warnings = SetpointWarnings()
    assert warnings.take(setpoint(8.0, broken=True))
    after = [*(8.0 + 0.01 * k for k in range(1, 400)), *(2.0 + 0.01 * k for k in range(1200))]
    over = [k for k, t in enumerate(after) if warnings.take(setpoint(t))]
    assert over == [399 + 1 + round(100 * SETTLED_S)]


def test_setpoints_that_are_not_finite_are_named_beside_broken_promises() -> None:
    warnings = SetpointWarnings()
    assert warnings.take(setpoint(0.0, broken=True, nan=True)) == (
        "promise broken: cf2; no finite setpoint: cf1"
    )
    warnings.take(setpoint(0.01))
    assert warnings.text == ""
