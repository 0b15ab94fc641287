"""Tests of what is reported of setpoints that a replanner cannot repair."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint

from q2q_model.signals.values import SetpointStatus, SwarmSetpoint
from q2q_planner.online.setpoint_warnings import SETTLED_S, SetpointWarnings, setpoint_warning

NAMES = ("cf1", "cf2")


def setpoint(t: float, *, broken: bool = False, nan: bool = False) -> SwarmSetpoint:
    pos, status = np.zeros((2, 3)), np.zeros(2, np.uint8)
    status[:] = SetpointStatus.SHIFTED
    if broken:
        status[1] = SetpointStatus.PROMISE_BROKEN
    if nan:
        pos[0, 2] = np.nan
    return resting_setpoint(t, NAMES, pos, status=status)


def test_a_warning_is_reported_once_until_it_has_been_over_for_a_while() -> None:
    warnings = SetpointWarnings()
    lines = [
        warnings.update(setpoint(0.01 * k, broken=100 <= k < 200 or k == 400)) for k in range(int(1e2 * 16))
    ]
    assert {k: line for k, line in enumerate(lines) if line} == {
        100: "promise broken: cf2",
        401 + round(100 * SETTLED_S): "setpoints have been good for 10 s",
    }
    assert warnings.update(setpoint(30.0, broken=True)) == "promise broken: cf2"


def test_a_clock_that_is_set_back_makes_no_time_of_sound_setpoints() -> None:
    """Sound from 8 s on, set back to 2 s at 12 s: 3.985 s of them, and 10 ms with each that follows."""
    warnings = SetpointWarnings()
    assert warnings.update(setpoint(8.0, broken=True))
    after = [*(8.005 + 0.01 * k for k in range(399)), *(2.0 + 0.01 * k for k in range(1200))]
    over = [k for k, t in enumerate(after) if warnings.update(setpoint(t))]
    assert over == [399 + 602]  # 3.985 s + 6.02 s


@pytest.mark.parametrize("off", [-1e6, -20.0, 20.0, 1e6])
@pytest.mark.parametrize(("broken", "unsound"), [(0, 0.02), (100, 1.01)])
def test_a_wrong_stamp_makes_no_time_of_sound_setpoints(off: float, broken: int, unsound: float) -> None:
    """Also if the last warning came under it; the steps to and from it count as `unsound` time [s]."""
    warnings, stamps = SetpointWarnings(), [2e6 + 0.01 * k + (off if k == 100 else 0.0) for k in range(1300)]
    over = [
        k for k, t in enumerate(stamps) if "been good" in warnings.update(setpoint(t, broken=k == broken))
    ]
    assert over == [pytest.approx(100 * (SETTLED_S + unsound), abs=1.0)]  # ticks


@pytest.mark.parametrize("name", ["pos", "vel", "acc", "yaw", "yaw_rate"])
def test_every_number_of_a_setpoint_must_be_finite(name: str) -> None:
    given = setpoint(0.0)
    values = getattr(given, name).copy()
    values[1] = np.inf
    assert setpoint_warning(replace(given, **{name: values})) == "no finite setpoint: cf2"


def test_setpoints_that_are_not_finite_are_named_beside_broken_promises() -> None:
    warnings = SetpointWarnings()
    assert warnings.update(setpoint(0.0, broken=True, nan=True)) == (
        "promise broken: cf2; no finite setpoint: cf1"
    )
    warnings.update(setpoint(0.01))
    assert warnings.text == ""
