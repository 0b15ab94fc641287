"""What is commanded as knowledge grows old, and how a command is said in the firmware's units."""

import numpy as np
import pytest

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.fallback_phases import apply_land_and_cut, fallback_command
from q2q_control.radio.link.rpyt_scale import RpytScale, rpyt_rows
from q2q_model.signals.values import CommandStatus, SwarmCommand

LAST = SwarmCommand(
    t=4.0,
    names=("cf1", "cf2"),
    thrust=np.array([0.3, 0.4]),
    roll=np.array([0.1, -0.1]),
    pitch=np.array([0.2, 0.0]),
    yaw_rate=np.array([0.0, 1.0]),
    status=np.zeros(2, np.uint8),
)
PARAMS = FallbackParams()
UP = np.zeros(2, dtype=np.bool_)


def test_a_late_tick_first_repeats_the_last_command() -> None:
    held = fallback_command(LAST, 0.0999, PARAMS, 0.33)
    assert held.status.tolist() == [CommandStatus.HOLD] * 2
    assert held.roll.tolist() == LAST.roll.tolist()
    assert held.thrust.tolist() == LAST.thrust.tolist()
    assert held.t == pytest.approx(4.0999)


def test_then_the_vehicles_level_out_at_hover_thrust() -> None:
    level = fallback_command(LAST, 0.10, PARAMS, 0.33)
    assert level.status.tolist() == [CommandStatus.LEVEL] * 2
    assert level.thrust.tolist() == [0.33, 0.33]
    assert level.t == pytest.approx(4.10)
    for angle in (level.roll, level.pitch, level.yaw_rate):
        assert angle.tolist() == [0.0, 0.0]


def test_each_vehicle_lands_by_its_own_age_level_and_sinking() -> None:
    output = apply_land_and_cut(LAST, np.array([0.999, 1.0]), UP, PARAMS, 0.33)
    assert output.status.tolist() == [CommandStatus.OK, CommandStatus.LAND]
    assert output.thrust.tolist() == [0.3, pytest.approx(0.94 * 0.33)]
    assert output.roll.tolist() == [0.1, 0.0]
    assert output.pitch.tolist() == [0.2, 0.0]
    assert output.yaw_rate.tolist() == [0.0, 0.0]
    assert output.t == LAST.t


def test_a_vehicle_that_is_down_gets_nothing_at_all() -> None:
    output = apply_land_and_cut(LAST, np.array([0.0, 0.0]), np.array([True, False]), PARAMS, 0.33)
    assert output.status.tolist() == [CommandStatus.CUT, CommandStatus.OK]
    assert output.thrust.tolist() == [0.0, 0.4]
    assert output.roll.tolist() == [0.0, -0.1]
    assert output.yaw_rate.tolist() == [0.0, 1.0]


def test_an_age_that_is_no_number_lands() -> None:
    output = apply_land_and_cut(LAST, np.array([np.nan, 0.0]), UP, PARAMS, 0.33)
    assert output.status.tolist() == [CommandStatus.LAND, CommandStatus.OK]


def test_young_knowledge_changes_nothing() -> None:
    assert apply_land_and_cut(LAST, np.array([0.5, 0.0]), UP, PARAMS, 0.33) is LAST


@pytest.mark.parametrize(
    "ages",
    [
        {"hold_after_s": 0.2, "level_after_s": 0.1},
        {"level_after_s": 0.9, "land_after_s": 0.5},
        {"land_after_s": 2.0, "cut_after_s": 1.0},
    ],
)
def test_ages_out_of_order_are_refused(ages: dict[str, float]) -> None:
    with pytest.raises(
        ValueError, match="; must satisfy hold_after_s <= level_after_s <= land_after_s <= cut_after_s"
    ):
        FallbackParams(**ages)


def test_phases_may_begin_together() -> None:
    assert FallbackParams(hold_after_s=0.1, level_after_s=0.1).hold_after_s == 0.1


def test_a_command_in_the_firmwares_units_is_pitch_roll_yaw_rate_in_degrees_and_pwm() -> None:
    rows = rpyt_rows(LAST, RpytScale(full_pwm_thrust=0.6))
    np.testing.assert_allclose(rows[0], [np.degrees(0.2), np.degrees(0.1), 0.0, 32768])  # half of 65535
    np.testing.assert_allclose(rows[1], [0.0, np.degrees(-0.1), np.degrees(1.0), 43690])  # two thirds


def test_thrust_beyond_the_scale_is_clipped_to_what_the_commander_accepts() -> None:
    assert rpyt_rows(LAST, RpytScale(full_pwm_thrust=0.35))[1, 3] == 60000
