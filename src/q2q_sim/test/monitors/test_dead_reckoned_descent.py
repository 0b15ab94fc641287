"""A vehicle that was sent down is exempt on the floor where that brought it down, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.signals.values import Array, CommandStatus
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.floor import floor
from q2q_sim.monitors.policies.inputs.trace_from_arrays import trace_from_arrays

T = 0.01 * np.arange(1200, dtype=np.float64)
SENT = np.full((len(T), 1, 3), [0.0, 0.0, 1.2])
AROUND = Circumstances()


def heights(*points: tuple[float, float]) -> Array:
    """Return the heights [m] of a vehicle by points of time [s] and height, (T,)."""
    t, z = np.array(points).T
    return np.asarray(np.interp(T, t, z))


def commands(since: float, until: float, status: float = CommandStatus.LAND) -> Array:
    """Return the commands of a vehicle that is sent down for a while, (T,)."""
    return np.where((since <= T) & (until > T), status, CommandStatus.OK)


STOPS = heights((6.25, 1.2), (7.0, 0.6), (8.0, 0.0), (8.5, 0.0), (9.5, 1.2))
"""Heights of a vehicle that sinks at 0.8 m/s until 7 s, and then stops on the floor [m], (T,)."""


def falls(z: Array, status: Array) -> list[float]:
    """Return when the policy finds a fall in a flight at 1.2 m, which its verdict names then [s]."""
    empty = FlightRecorder(("cf1",), len(T)).flight("made")
    pos = SENT.copy()
    pos[:, 0, 2] = z
    flight = replace(empty, t=T, true_pos=pos, ref_pos=SENT, command_status=status[:, None])
    found = judge(trace_from_arrays(flight), AROUND, {"floor": floor})
    words = str(verdict_of(flight, AROUND))
    assert ("hit the floor" in words) == bool(found)
    assert all(f"cf1 hit the floor at {one.t:.1f} s" in words for one in found)
    return [one.t for one in found]


def test_a_fall_long_after_a_short_order_to_land_is_named_when_it_happens() -> None:
    """Sent down for 0.07 s, flown for 2 s, and fallen from 1.2 m within 3.5 s of the order."""
    fallen = heights((5.0, 1.2), (5.5, 0.0))
    assert falls(fallen, commands(2.99, 3.06)) == pytest.approx([5.5], abs=0.011)  # below 2 cm


def test_a_fall_soon_after_an_order_to_land_is_named_where_it_was_not_sinking() -> None:
    hovering = heights((0.0, 1.21), (4.0, 1.2), (4.5, 0.0))
    assert falls(hovering, commands(2.99, 3.06)) == pytest.approx([4.5], abs=0.011)


@pytest.mark.parametrize(
    ("sinking", "left", "brakes", "is_exempt"),
    [
        (0.8, 0.6, 1.5, True),  # 0.7 m to stop from 0.8 m/s in 1.75 s
        (0.8, 0.8, 1.5, False),
        (0.3, 0.2, 1.5, True),
        (0.3, 0.3, 1.5, False),
        (0.8, 0.6, 2.0, False),
    ],
)
def test_a_vehicle_found_as_it_sinks_is_exempt_as_far_as_it_needs_to_stop(
    sinking: float, left: float, brakes: float, is_exempt: bool
) -> None:
    sent, down = 7.0 - (1.2 - left) / sinking, 7.0 + brakes
    z = heights((sent, 1.2), (7.0, left), (down, 0.0), (down + 0.5, 0.0), (down + 1.0, 1.2))
    found = falls(z, commands(sent, 7.0))
    assert found == ([] if is_exempt else pytest.approx([down], abs=0.1))


@pytest.mark.parametrize("noise", [0.5e-3, 2e-3])
def test_noise_of_the_positions_makes_no_fall_of_a_descent(noise: float) -> None:
    """As above, with 0.7 m to stop and 0.58 m of them needed."""
    random = np.random.default_rng(0)
    for _ in range(20):
        z = STOPS + noise * random.standard_normal(len(T))
        assert falls(z, commands(6.25, 7.0)) == []


@pytest.mark.parametrize("until", [7.0, 7.01])
def test_positions_at_half_the_rate_of_the_ticks_make_no_fall_of_a_descent(until: float) -> None:
    assert falls(STOPS[2 * (np.arange(len(T)) // 2)], commands(6.25, until)) == []


@pytest.mark.parametrize("until", [7.0, 7.01])
def test_the_held_state_of_a_lost_vehicle_does_not_tell_how_it_sank(until: float) -> None:
    assert falls(np.where((T > 6.0) & (T < 7.005), 1.2, STOPS), commands(6.25, until)) == []


@pytest.mark.parametrize(("until", "has_fallen"), [(9.4, False), (9.6, True)])
def test_one_that_does_not_take_off_again_has_fallen_when_it_came_down(
    until: float, has_fallen: bool
) -> None:
    """Sent down until 6 s, so that it has until 9.5 s."""
    z = heights((4.5, 1.2), (6.1, 0.0), (until, 0.0), (until + 0.01, 0.2), (until + 1.0, 1.2))
    assert falls(z, commands(4.0, 6.0)) == (pytest.approx([6.1], abs=0.05) if has_fallen else [])


def test_a_later_fall_of_one_that_took_off_again_is_another() -> None:
    z = heights((4.5, 1.2), (6.1, 0.0), (7.0, 0.0), (8.0, 1.2), (9.0, 1.2), (9.4, 0.0))
    assert falls(z, commands(4.0, 6.0)) == pytest.approx([9.4], abs=0.02)


def test_one_whose_motors_were_cut_falls_as_it_was_sent_if_no_command_follows() -> None:
    status = commands(4.0, 4.05, CommandStatus.CUT)
    fallen = heights((4.0, 1.2), (4.5, 0.0), (5.0, 0.0), (5.5, 1.2))
    assert falls(fallen, np.where(T >= 4.05, np.nan, status)) == []
    assert falls(heights((6.0, 1.2), (6.5, 0.0)), status) == pytest.approx([6.5], abs=0.02)


def test_where_it_was_as_it_was_sent_down_need_not_be_known() -> None:
    z = heights((4.5, 1.2), (6.1, 0.0), (7.0, 0.0), (8.0, 1.2))
    assert falls(np.where((T > 4.3) & (T < 6.5), np.nan, z), commands(4.0, 6.0)) == []
