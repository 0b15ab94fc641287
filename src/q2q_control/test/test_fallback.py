"""What is commanded when ticks stay away, and how a command is said in the firmware's units."""

import numpy as np
import pytest

from q2q_control.fallback import FallbackParams, fallback_command
from q2q_control.legacy import PWM_MAX, LegacyScale, legacy_setpoints
from q2q_model.signals import CommandStatus, SwarmCommand

LAST = SwarmCommand(
    t=4.0,
    names=("cf1", "cf2"),
    thrust=np.array([0.3, 0.4]),
    roll=np.array([0.1, -0.1]),
    pitch=np.array([0.2, 0.0]),
    yaw_rate=np.array([0.0, 1.0]),
    status=np.zeros(2, np.uint8),
)


def test_a_tick_that_is_merely_late_changes_nothing() -> None:
    assert fallback_command(LAST, 0.02, FallbackParams(), 0.33) is None


def test_then_the_last_command_is_held() -> None:
    held = fallback_command(LAST, 0.05, FallbackParams(), 0.33)
    assert held is not None
    assert held.status.tolist() == [CommandStatus.HOLD] * 2
    assert held.roll.tolist() == LAST.roll.tolist()
    assert held.t == pytest.approx(4.05)


def test_then_the_vehicles_level_out_at_hover_thrust() -> None:
    level = fallback_command(LAST, 0.2, FallbackParams(), 0.33)
    assert level is not None
    assert level.status.tolist() == [CommandStatus.LEVEL] * 2
    assert level.thrust.tolist() == [0.33, 0.33]
    assert not level.roll.any()
    assert not level.pitch.any()
    assert not level.yaw_rate.any()


def test_then_the_firmwares_watchdog_is_left_to_act() -> None:
    assert fallback_command(LAST, 0.45, FallbackParams(), 0.33) is None


def test_ages_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="must rise"):
        FallbackParams(hold_s=0.2, level_s=0.1)


def test_a_command_in_the_firmwares_units_is_pitch_roll_yaw_rate_in_degrees_and_pwm() -> None:
    rows = legacy_setpoints(LAST, LegacyScale(thrust_max=0.6))
    np.testing.assert_allclose(rows[0], [np.degrees(0.2), np.degrees(0.1), 0.0, PWM_MAX / 2])
    np.testing.assert_allclose(rows[1], [0.0, np.degrees(-0.1), np.degrees(1.0), round(PWM_MAX * 2 / 3)])


def test_thrust_beyond_the_scale_is_clipped_to_what_the_commander_accepts() -> None:
    assert legacy_setpoints(LAST, LegacyScale(thrust_max=0.35))[1, 3] == PWM_MAX
