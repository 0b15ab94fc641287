"""Records, gains, lag and dev come out as they were put in."""

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest
from made_flights import LOOP, Pass, made_flight, record_of
from scipy.integrate import solve_ivp

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.flights.flight import Flight, of_rows, of_vehicle
from q2q_model.identification.deviation import DeviationParams, fit_decay, overlap_of
from q2q_model.identification.gain_notes import gain_notes
from q2q_model.identification.gains.altitude_from_flight import altitude_record, altitude_records
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.identification.gains.impulse_response import downwash_response, free_response, impulse_response
from q2q_model.identification.gains.trajectory_gains import (
    gains_by_powell,
    gains_from_trajectories,
    is_better,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

PLAIN = AltitudeLoop(k_p=0.81, k_d=0.43)
RICH = AltitudeLoop(k_p=0.81, k_d=0.43, k_i=0.1, offset=0.2, lag=0.1)
CALM = Pass(law=NoInteraction(), start=0.3, noise=1e-4)
PASSES = [Pass(name=f"gap {gap}", gap=gap, noise=1e-4) for gap in (0.4, 0.6, 0.9)]


@pytest.mark.parametrize("loop", [PLAIN, RICH])
def test_the_loops_exact_response_is_that_of_an_accurate_solver(loop: AltitudeLoop):
    dt, ticks = 0.01, 800
    t = np.arange(ticks) * dt
    eta = np.interp(t, [3.0, 4.0, 5.0], [0.0, -1.0, 0.0], left=0.0, right=0.0)
    start = np.array([[0.1], [-0.05]])

    def rate(when: float, x: np.ndarray) -> list[float]:
        demanded = -loop.k_p * x[0] - loop.k_d * x[1] + loop.k_i * x[2] + loop.offset
        downwash = np.interp(when, t, eta)
        commanded_acc = x[3] if loop.lag else demanded
        return [x[1], commanded_acc + downwash, -x[0], (demanded - x[3]) / loop.lag if loop.lag else 0.0]

    settled = loop.offset - loop.k_p * 0.1 + loop.k_d * 0.05
    exact = {"rtol": 1e-9, "atol": 1e-11, "max_step": 0.05}
    solved = solve_ivp(rate, (0.0, t[-1]), [0.1, -0.05, 0.0, settled], t_eval=t, **exact)
    found = free_response(loop, dt, start, np.zeros((ticks, 1))) + downwash_response(loop, dt, eta[:, None])
    np.testing.assert_allclose(found[:, 0], solved.y[0], atol=1e-7)  # the solver's own error


def test_the_response_to_any_downwash_is_its_convolution_with_the_impulse_response():
    eta = np.random.default_rng(12).standard_normal((300, 2))
    eta[0] = 0.0
    h = impulse_response(RICH, 0.01, 300)
    expected = np.stack([np.convolve(h, eta[:, k])[:300] for k in range(2)], axis=1)
    np.testing.assert_allclose(downwash_response(RICH, 0.01, eta), expected, atol=1e-12)


def test_a_vehicle_that_starts_beside_its_moving_reference_catches_up_without_knowing_its_jerk():
    """With lag the reference's jerk drives the error: a steady jerk j leaves -T j / K_p."""
    ticks = 4000
    loop = AltitudeLoop(k_p=4.0, k_d=4.0, lag=0.05)
    error = free_response(loop, 0.01, np.zeros((2, 1)), np.full((ticks, 1), 0.3))
    assert error[-1, 0] == pytest.approx(-0.05 * 0.3 / 4.0, rel=1e-6)


def test_gains_from_commands_are_those_that_flew_and_lie_inside_their_interval():
    loop = replace(LOOP, offset=0.15)
    fit = gains_from_commands([record_of(Pass(loop=loop, start=0.2, noise=1e-4))])
    assert fit.k_p.low <= loop.k_p <= fit.k_p.high
    assert fit.k_d.low <= loop.k_d <= fit.k_d.high
    assert fit.k_p.high - fit.k_p.low < 0.01 * loop.k_p
    assert fit.needs_offset
    assert not fit.needs_integral
    assert fit.loop.offset == pytest.approx(0.15, rel=1e-6)


def test_terms_that_did_not_fly_are_not_asked_for():
    fit = gains_from_commands([record_of(PASSES[0])])
    assert not fit.needs_offset
    assert not fit.needs_integral
    assert fit.loop.k_i == fit.loop.offset == 0.0


def test_rows_in_which_a_limit_cut_the_command_do_not_move_the_gains():
    record = record_of(CALM)
    commanded_acc = record.commanded_acc.copy()
    commanded_acc[100:150] = 0.05
    fit = gains_from_commands([replace(record, commanded_acc=commanded_acc)])
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)  # 50 of 6000 rows, all wrong the same way


def random_walk(given: Array, dt: float = 0.01) -> AltitudeRecord:
    """Return a vehicle that is given accelerations (T,), with a velocity setpoint cut at 0.25 m/s.

    It follows 0.2 s late. The record has the derivative of its velocity setpoint, and not what was given.
    """
    limited = np.clip((np.cumsum(given) - 0.5 * given) * dt, -0.25, 0.25)
    place = np.cumsum(limited) * dt
    ref = np.stack([place, limited, np.gradient(limited, dt)], axis=-1)[:, None]  # (T, 1, 3)
    pos, vel, empty = (np.zeros((given.size, 1, 3)) for _ in range(3))
    for values, wanted in ((pos, place), (vel, limited)):
        values[:, 0, 2] = first_order_lag(wanted[:, None], dt * np.arange(given.size), 0.2)[:, 0]
    error, rate = (ref[..., k] - values[..., 2] for k, values in enumerate((pos, vel)))
    commanded = given[:, None] + LOOP.k_p * error + LOOP.k_d * rate
    commanded += 0.01 * np.random.default_rng(3).standard_normal(commanded.shape)
    unknown, t = np.full_like(commanded, np.nan), dt * np.arange(given.size)
    return AltitudeRecord(
        "walk", ("a",), dt, t, pos, vel, empty, ref, commanded, unknown, 0.0 * commanded, 0, t.size,
        acc_differentiated=True,
    )  # fmt: skip


def test_rows_in_which_the_velocity_setpoint_is_at_its_limit_do_not_move_the_gains():
    """There its derivative is not the acceleration that the controller was given."""
    t = np.arange(0.0, 60.0, 0.01)
    record = random_walk(0.6 * np.cos(1.5 * t) + 0.3 * np.cos(0.7 * t))
    fit = gains_from_commands([record])
    assert fit.limited == pytest.approx((np.abs(record.ref[..., 1]) == 0.25).mean(), abs=0.03)
    assert fit.k_p.low <= LOOP.k_p <= fit.k_p.high
    assert fit.k_d.low <= LOOP.k_d <= fit.k_d.high
    assert fit.k_p.high - fit.k_p.low < 0.1 * LOOP.k_p
    assert gain_notes(fit, [], CRAZYFLIE_2_0)[0].startswith(f"{fit.limited:.0%} of the rows with commands")


def oscillation(made: Flight, acc_of: Callable[[Array, Array], Array]) -> Flight:
    """Return a flight that follows a vertical sine too, with z_ref'' of the record made of t and z_ref'."""
    place, rate = 0.2 * np.sin(2.0 * made.t), 0.4 * np.cos(2.0 * made.t)
    given, recorded = -0.8 * np.sin(2.0 * made.t), acc_of(made.t, rate)
    moves = {
        **dict.fromkeys(("pos", "mocap_pos", "ref_pos"), place),
        **dict.fromkeys(("vel", "ref_vel"), rate),
        "ref_acc": recorded,
    }
    up = np.array([0.0, 0.0, 1.0])
    found = {name: getattr(made, name) + one[:, None, None] * up for name, one in moves.items()}
    return replace(made, thrust=made.thrust + CRAZYFLIE_2_0.mass * given[:, None], **found)


def test_rows_at_the_largest_velocity_count_where_accelerations_are_recorded() -> None:
    calm = made_flight(CALM)
    record = altitude_record(oscillation(calm, lambda t, _: -0.8 * np.sin(2.0 * t)), CRAZYFLIE_2_0)
    moving = gains_from_commands([record])
    assert moving.limited == 0.0
    assert moving.k_p.value == pytest.approx(LOOP.k_p, rel=1e-4)
    assert moving.k_d.value == pytest.approx(LOOP.k_d, rel=1e-4)


@pytest.mark.parametrize("lost", [(), (slice(1000, 1002), slice(1500, 1501))])
def test_accelerations_that_are_differences_of_velocities_are_found(lost: tuple[slice, ...]) -> None:
    flight = oscillation(made_flight(CALM), lambda t, rate: np.gradient(rate, t))
    record = altitude_record(without(flight, *lost), CRAZYFLIE_2_0)
    # of a sine, arccos(0.98) on both sides of a top and of a bottom: 0.128; 3 rows more on each: 0.038
    assert gains_from_commands([record]).limited == pytest.approx(0.166, abs=0.01)


def test_vehicles_that_climb_at_a_constant_rate_have_the_gains_of_hovering_ones():
    """All their rows are at the largest velocity, and its derivative is right."""
    still = record_of(CALM)
    pos, vel, ref = still.pos.copy(), still.vel.copy(), still.ref.copy()
    pos[..., 2] += 0.2 * still.t[:, None]
    ref[..., 0] += 0.2 * still.t[:, None]
    vel[..., 2] += 0.2
    ref[..., 1] += 0.2
    risen = replace(still, pos=pos, vel=vel, ref=ref)
    hovering, climbing = gains_from_commands([still]), gains_from_commands([risen])
    assert climbing.limited == 0.0
    assert climbing.k_p.as_list() == pytest.approx(hovering.k_p.as_list(), rel=1e-6)
    assert climbing.k_d.as_list() == pytest.approx(hovering.k_d.as_list(), rel=1e-6)


def test_the_ground_and_holes_in_the_positions_do_not_move_the_gains():
    made = made_flight(CALM)
    stands, unseen = np.arange(2000), np.arange(2300, 2700)
    pos, vel, thrust = made.pos.copy(), made.vel.copy(), made.thrust.copy()
    pos[stands, :, 2], vel[stands], thrust[stands] = 0.0, 0.0, 0.0  # below a reference 1 m up, motors off
    pos[unseen, 1], vel[unseen, 1] = np.nan, np.nan
    mocap = np.where(np.isfinite(pos), made.mocap_pos, np.nan)
    record = altitude_record(replace(made, pos=pos, vel=vel, thrust=thrust, mocap_pos=mocap), CRAZYFLIE_2_0)
    fit = gains_from_commands([record])
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)  # noise of 0.1 mm in an error of 10 mm
    assert fit.k_d.value == pytest.approx(LOOP.k_d, rel=1e-3)
    assert np.isnan(record.commanded_acc[stands]).all()
    assert np.isnan(record.commanded_acc[unseen, 1]).all()
    assert np.isfinite(record.commanded_acc[unseen, 0]).all()


def test_a_flight_without_commands_is_refused_with_the_way_out():
    record = record_of(CALM)
    missing = "0 rows with thrust commands in 1 flight, 200 needed, at references with rates"
    with pytest.raises(ValueError, match=missing):
        gains_from_commands([replace(record, commanded_acc=np.full_like(record.commanded_acc, np.nan))])


def test_trajectories_alone_give_the_gains_of_a_loop_without_lag():
    record = record_of(replace(CALM, loop=PLAIN, noise=1e-5))
    fit = gains_from_trajectories([record])
    found = dict(fit.intervals)
    assert found["k_p"].value == pytest.approx(0.81, rel=2e-3)  # the physics steps by 2 ms: order K_d dt
    assert found["k_d"].value == pytest.approx(0.43, rel=5e-3)


@pytest.mark.parametrize("filtered", [np.nan, 1e3])
@pytest.mark.parametrize("on_the_ground", [0, 50])
def test_positions_in_millimetres_are_named(filtered: float, on_the_ground: int):
    flight = made_flight(CALM)
    mocap, pos = 1e3 * flight.mocap_pos, filtered * flight.pos
    mocap[:on_the_ground], pos[:on_the_ground] = 0.0, 0.0 * filtered
    with pytest.raises(ValueError, match=r"x, y, z of \w+ in .* reach .* are they in metres\?"):
        altitude_record(replace(flight, mocap_pos=mocap, pos=pos), CRAZYFLIE_2_0)


def test_gains_that_a_flight_does_not_show_have_intervals_that_say_so():
    """Both vehicles stay where they should be: no gains are better than any others."""
    still = replace(CALM, start=0.0, noise=0.0)
    found = dict(
        gains_from_trajectories([record_of(still), record_of(replace(still, name="again"))]).intervals
    )
    for name, flown in (("k_p", LOOP.k_p), ("k_d", LOOP.k_d)):
        assert found[name].low <= flown <= found[name].high
        assert not found[name].is_positive


def test_a_lag_hides_in_the_damping_that_trajectories_show():
    fit = gains_from_trajectories([record_of(CALM)])
    assert fit.loop.k_d == pytest.approx(LOOP.k_d - LOOP.k_p * LOOP.lag, rel=0.05)  # next order: K_d^2 T


def test_powell_through_a_solver_finds_the_same_gains_less_exactly():
    record = record_of(replace(CALM, loop=PLAIN, seconds=12.0, noise=1e-5))
    powell, exact = gains_by_powell([record]).loop, gains_from_trajectories([record]).loop
    assert powell.k_p == pytest.approx(exact.k_p, rel=0.03)
    assert powell.k_d == pytest.approx(exact.k_d, rel=0.03)  # solve_ivp's tolerance moves K_d by 0.007


def test_an_offset_is_found_where_there_is_one_and_only_there():
    with_one = [record_of(replace(CALM, loop=AltitudeLoop(0.81, 0.43, offset=0.1)))]
    without = [record_of(replace(CALM, loop=PLAIN))]
    more, less = (gains_from_trajectories(with_one, options) for options in (("offset",), ()))
    assert is_better(more, less)
    assert more.loop.offset == pytest.approx(0.1, rel=0.01)
    assert not is_better(gains_from_trajectories(without, ("offset",)), gains_from_trajectories(without))


def settling(seconds: float, rng: np.random.Generator) -> AltitudeRecord:
    """Return a vehicle that settles from some 10 cm, at 50 Hz, with noise of 2 mm and without an offset."""
    t, loop = np.arange(0.0, seconds, 0.02), AltitudeLoop(k_p=4.0, k_d=2.5)
    start = np.array([[0.1], [0.05]]) * rng.standard_normal((2, 1))
    error = free_response(loop, 0.02, start, np.zeros((t.size, 1)))
    error[1:] += 0.002 * rng.standard_normal((t.size - 1, 1))
    pos, vel, still, ref = (np.zeros((t.size, 1, 3)) for _ in range(4))
    pos[..., 2], vel[0, :, 2], ref[..., 0] = 1.0 + error, start[1], 1.0
    unknown = np.full((t.size, 1), np.nan)
    return AltitudeRecord(
        "settling", ("a",), 0.02, t, pos, vel, still, ref, unknown, unknown, 0.0 * error, 0, t.size
    )


def test_a_short_record_weighs_by_its_rows_in_the_test_of_an_offset():
    """Six offsets that fit noise in 2.5 s each do not count as much as 30 s."""
    for seed in (0, 10):
        rng = np.random.default_rng(seed)
        records = [settling(seconds, rng) for seconds in (30.0, 2.5, 2.5, 2.5, 2.5, 2.5)]
        plain, shifted = gains_from_trajectories(records), gains_from_trajectories(records, ("offset",))
        rows = np.array([record.t.size for record in records])
        assert plain.rms**2 * rows.sum() == pytest.approx(np.concatenate(plain.mse) @ rows, rel=1e-9)
        assert not is_better(shifted, plain)


def test_gains_come_out_though_every_flight_has_an_offset_of_its_own():
    loop = AltitudeLoop(8.0, 5.0)
    records = [
        record_of(replace(CALM, name=f"offset {offset}", loop=replace(loop, offset=offset)))
        for offset in (0.6, -0.4, 0.2)
    ]
    plain, shifted = gains_from_trajectories(records), gains_from_trajectories(records, ("offset",))
    assert abs(plain.loop.k_p - 8.0) > 2.0
    assert is_better(shifted, plain)
    assert shifted.loop.k_p == pytest.approx(8.0, rel=0.02)
    assert shifted.loop.k_d == pytest.approx(5.0, rel=0.02)
    assert shifted.loop.offset == pytest.approx((0.6 - 0.4 + 0.2) / 3.0, rel=0.02)


def test_flights_of_one_and_of_two_vehicles_give_gains_together():
    both = replace(CALM, loop=PLAIN, noise=1e-5)
    alone = altitude_record(of_vehicle(made_flight(both), "cf1"), CRAZYFLIE_2_0)
    fit = gains_from_trajectories([record_of(both), alone])
    assert [one.shape for one in fit.mse] == [(2,), (1,)]
    assert fit.loop.k_p == pytest.approx(0.81, rel=2e-3)


def test_dev_is_the_mean_of_both_deviations_while_above_each_other():
    record = record_of(replace(PASSES[0], noise=0.0))
    overlap = overlap_of(record, DeviationParams(steady=0.0))
    assert overlap is not None
    over = np.hypot(*(record.pos[:, 1] - record.pos[:, 0])[:, :2].T) <= 0.1
    away = np.abs(record.pos[over, :, 2] - [1.0, 1.4]).sum(axis=1)
    assert overlap.dev == pytest.approx(away.mean(), rel=0.02)  # less the clear-air bias, a few of a percent
    assert overlap.gap == pytest.approx(np.abs(np.diff(record.pos[over, :, 2], axis=1)).mean())


def test_a_constant_deviation_in_clear_air_is_no_disturbance():
    record = record_of(PASSES[0])
    ref = record.ref.copy()
    ref[..., 0] += 0.03
    shifted = replace(record, ref=ref)
    before, after = (overlap_of(one, DeviationParams(steady=0.0)) for one in (record, shifted))
    assert before is not None
    assert after is not None
    assert after.dev == pytest.approx(before.dev, rel=1e-6)


def test_a_short_excursion_in_clear_air_does_not_move_the_bias():
    record = record_of(PASSES[0])
    alone = np.hypot(*(record.pos[:, 1] - record.pos[:, 0])[:, :2].T) > 0.5
    pos = record.pos.copy()
    pos[np.flatnonzero(alone)[: alone.sum() // 10], :, 2] += 0.5
    before, after = (
        overlap_of(one, DeviationParams(steady=0.0)) for one in (record, replace(record, pos=pos))
    )
    assert before is not None
    assert after is not None
    assert after.dev == pytest.approx(before.dev, abs=1e-3)  # a mean would move by 50 mm a vehicle


def test_the_decay_fit_finds_the_law_it_was_drawn_from_and_says_when_d_was_not_flown():
    decay = fit_decay([record_of(one) for one in PASSES], DeviationParams(steady=0.0, allowed=0.005))
    gaps = np.array([overlap.gap for overlap in decay.overlaps])
    devs = np.array([overlap.dev for overlap in decay.overlaps])
    curve = decay.alpha.value * np.exp(-decay.beta.value * gaps)
    np.testing.assert_allclose(curve, devs, rtol=0.05)  # the paper's law is no exponential
    assert decay.alpha.value * np.exp(-decay.beta.value * decay.d.value) == pytest.approx(0.005, rel=1e-6)
    assert decay.extrapolated
    assert decay.d.low <= decay.d.value <= decay.d.high


def test_two_flights_determine_no_interval_of_the_decay():
    flights = [record_of(one) for one in PASSES[:2]]
    decay = fit_decay(flights, DeviationParams(steady=0.0, allowed=0.005))
    assert decay.d.low == 0.0
    assert decay.d.high == 10.0  # the bound of d: above the height of any flight room
    assert decay.alpha.high > 1e6  # two flights, two parameters: no residual says how well they are known
    assert decay.beta.high - decay.beta.low > 10.0


def test_one_flight_with_overlap_gives_no_decay():
    near = record_of(PASSES[0])
    with pytest.raises(ValueError, match="1 of 2 flights have vehicles within"):
        fit_decay(
            [near, replace(near, name="far", pos=near.pos + np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))]
        )


def test_pieces_of_one_flight_count_as_one_in_the_decay():
    one, other = (record_of(each) for each in PASSES[:2])
    with pytest.raises(ValueError, match="1 of 1 flights have vehicles within"):
        fit_decay([one, replace(other, name=one.name)])
    params = DeviationParams(steady=0.0, allowed=0.005)
    decay = fit_decay([one, replace(one, name="again"), replace(other, name="again")], params)
    first, joined = decay.overlaps
    alone = fit_decay([one, other], params).overlaps[1]
    assert joined.seconds == pytest.approx(first.seconds + alone.seconds)
    expected = (first.gap * first.seconds + alone.gap * alone.seconds) / joined.seconds
    assert joined.gap == pytest.approx(expected)


def test_holes_and_outliers_are_mended_and_counted():
    flight = made_flight(replace(CALM, noise=0.0))
    pos = flight.mocap_pos.copy()
    pos[500, 0] += [0.0, 0.0, 1.0]
    pos[700:720, 1] = np.nan
    unfiltered = replace(flight, mocap_pos=pos, pos=np.full_like(pos, np.nan), vel=np.full_like(pos, np.nan))
    record = altitude_record(unfiltered, CRAZYFLIE_2_0)
    assert record.outliers == 1
    assert record.samples == 2 * record.t.size - 20
    np.testing.assert_allclose(record.pos, flight.true_pos, atol=1e-4)  # a line over 0.2 s of a slow swing


def without(flight: Flight, *holes: slice) -> Flight:
    """Return a flight without some of its ticks."""
    kept = np.ones(flight.t.size, dtype=bool)
    for hole in holes:
        kept[hole] = False
    return of_rows(flight, kept)


def test_nothing_is_inferred_across_a_hole():
    flight = made_flight(CALM)
    whole, holed = record_of(CALM), without(flight, slice(1000, 1100), slice(1150, 1200), slice(2000, 2020))
    found, remarks = altitude_records(holed, CRAZYFLIE_2_0)
    assert len(remarks) == 1
    assert remarks[0].startswith("pass: 2 holes, the longest a hole of 1.0 s at t = 9.99 s, or a jump")
    assert remarks[0].endswith("; without 1 piece shorter than 2 s")
    assert [one.t.size for one in found] == [1000, 1800]  # 0.2 s without a tick are interpolated
    for one, first in zip(found, (0, 1200), strict=True):
        rows = slice(first, first + one.t.size)
        np.testing.assert_allclose(one.t, flight.t[rows], atol=1e-9)
        np.testing.assert_allclose(one.pos, whole.pos[rows], atol=1e-3)  # noise of 0.1 mm, a line over 0.2 s
        np.testing.assert_allclose(one.start[0], whole.deviation[first], atol=1e-9)
        ticks = np.isin(np.arange(3000)[rows], np.arange(2000, 2020), invert=True)
        np.testing.assert_allclose(one.commanded_acc[ticks], whole.commanded_acc[rows][ticks], atol=1e-9)
    with pytest.raises(ValueError, match=r"never last for 2\.0 s together"):
        altitude_records(without(flight, *(slice(k, k + 50) for k in range(100, 3000, 200))), CRAZYFLIE_2_0)


def test_two_flights_in_one_bag_are_two_records():
    first, second = made_flight(CALM), made_flight(PASSES[0])
    joined = {
        field.name: np.concatenate([getattr(first, field.name), getattr(second, field.name)])
        for field in fields(Flight)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    both = replace(first, **joined | {"t": np.concatenate([first.t, second.t + 100.0])})
    found, remarks = altitude_records(both, CRAZYFLIE_2_0)
    assert "hole of 70.0 s at t = 29.99 s" in remarks[0]
    for one, alone in zip(found, (record_of(CALM), record_of(PASSES[0])), strict=True):
        np.testing.assert_allclose(one.deviation, alone.deviation, atol=1e-9)
        np.testing.assert_allclose(one.commanded_acc, alone.commanded_acc, atol=1e-9)
    fit = gains_from_commands(found)
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)


def test_a_vehicle_out_of_sight_is_not_made_up():
    flight = made_flight(CALM)
    pos = np.where(np.isin(np.arange(flight.t.size), np.arange(900, 1000))[:, None, None], np.nan, flight.pos)
    pos[:, 0] = flight.pos[:, 0]
    found, remarks = altitude_records(replace(flight, pos=pos, mocap_pos=pos), CRAZYFLIE_2_0)
    assert "hole of 1.0 s at t = 8.99 s" in remarks[0]
    assert [one.t.size for one in found] == [900, 2000]


def with_third(flight: Flight, place: Array) -> Flight:
    """Return a flight with a third vehicle of which only positions (T, 3) were recorded."""
    arrays = {field.name: getattr(flight, field.name) for field in fields(Flight)}
    unknown = {k: np.full_like(v[:, :1], np.nan) for k, v in arrays.items() if np.ndim(v) > 1}
    third = unknown | {"pos": place[:, None], "mocap_pos": place[:, None]}
    joined = {k: np.concatenate([arrays[k], one], axis=1) for k, one in third.items()}
    return replace(flight, names=(*flight.names, "spare"), **joined)


def test_a_vehicle_that_only_stands_there_is_left_out_and_named():
    flight = made_flight(CALM)
    place = np.tile([3.0, 3.0, 0.02], (flight.t.size, 1))
    found, remarks = altitude_records(with_third(flight, place), CRAZYFLIE_2_0)
    assert remarks == ["pass: spare never flew: left out of the gains"]
    np.testing.assert_array_equal(found[0].pos, record_of(CALM).pos)
    place[1000:1100, 2] = 0.5
    with pytest.raises(ValueError, match="together: there is no reference of spare; record"):
        altitude_records(with_third(flight, place), CRAZYFLIE_2_0)


def test_a_flight_without_a_reference_says_what_to_record():
    flight = made_flight(CALM)
    blind = replace(flight, ref_pos=np.full_like(flight.ref_pos, np.nan))
    with pytest.raises(ValueError, match="record the topics mocap"):
        altitude_record(blind, CRAZYFLIE_2_0)


def test_the_paper_law_pushes_the_made_flights_lower_vehicle_down():
    flight = made_flight(PASSES[0])
    strongest = -PAPER_LAW.strength * (0.83 / 0.73) ** 2
    assert flight.true_eta[:, 0, 2].min() == pytest.approx(strongest, rel=0.1)  # it sinks a little
