"""An air learned from flights in a known air has the known values within its intervals."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from known_air import ABSORPTION, PITCH, RESIDUAL, ROLL, SECONDS, assert_within, value
from synthetic_air import DT, Wake, flown, orbit, process, still_record, wide_jet, with_push
from threadpoolctl import threadpool_limits

from q2q_model.identification.push.along_flight import Motion
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, ROTOR_RADIUS
from q2q_sim.air.learning.absorption_term import absorption_term, sum_of_two
from q2q_sim.air.learning.edge_torque_term import edge_torque_term
from q2q_sim.air.learning.ground_term import ONE_ROTOR, ground_term
from q2q_sim.air.learning.jet.jet_coordinates import Travel, jet_place
from q2q_sim.air.learning.jet.jet_table import push_in_table
from q2q_sim.air.learning.jet.jet_term import jet_alone, jet_term
from q2q_sim.air.learning.jet.learned_downwash import learned_downwash
from q2q_sim.air.learning.jet.leave_one_group_out import HeldOutGroup, held_out_groups
from q2q_sim.air.learning.records.air_record import AirRecord, Motors
from q2q_sim.air.learning.records.motor_curve import USUAL_POWER
from q2q_sim.air.learning.residual.residual_term import residual_term
from q2q_sim.air.learning.wind_term import wind_term


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Solve small systems on one thread, as the command does."""
    with threadpool_limits(1, user_api="blas"):
        yield


@pytest.fixture(scope="module")
def pairs() -> list[AirRecord]:
    """Return two flights of a pair in a known jet and residual."""
    wake = Wake(wide_jet(), None, RESIDUAL)
    return [flown(f"pair{k}", orbit(SECONDS, (0.6, 1.05), k), wake, k) for k in range(2)]


def test_a_jet_is_met_where_a_level_source_left_it_and_its_speed_carried_it() -> None:
    t = np.arange(0.0, 1.0, DT)
    speed = np.array([1.0, -0.5, 0.0])
    pos = np.zeros((t.size, 2, 3))
    pos[:, 1] = [0.0, 0.0, 0.6] + t[:, None] * speed
    vel = np.zeros_like(pos)
    vel[:, 1] = speed
    up = np.broadcast_to([0.0, 0.0, 1.0], pos.shape)
    record = still_record("straight", Motion(t, pos, vel, up))
    place = jet_place(record, (0, 1), np.array([80]), Travel(slowness=0.25, carried=0.4, slope=1.0))
    tau = 0.25 * 0.6
    axis = (t[80] - tau + 0.4 * tau) * speed[:2]  # where it was, and what its air kept of its speed
    assert place.gap[0] == pytest.approx(0.6)
    assert place.radius[0] == pytest.approx(np.hypot(*axis))
    assert place.toward[0] == pytest.approx(axis / np.hypot(*axis))


def test_a_jet_points_along_minus_body_z_of_its_source() -> None:
    t = np.arange(0.0, 1.0, DT)
    pos = np.zeros((t.size, 2, 3))
    pos[:, 1, 2] = 0.5
    axis = np.broadcast_to([0.0, 0.0, 1.0], pos.shape).copy()
    axis[:, 1] = np.array([0.1, 0.0, 1.0]) / np.hypot(0.1, 1.0)  # accelerates to +x, blows to -x
    record = still_record("tilted", Motion(t, pos, np.zeros_like(pos), axis))
    place = jet_place(record, (0, 1), np.array([50]), Travel(slowness=0.2, carried=1.0, slope=0.8))
    assert place.toward[0] * place.radius[0] == pytest.approx([-0.8 * 0.1 * 0.5, 0.0])


def test_the_jet_and_its_travel_are_found() -> None:
    known = wide_jet()
    found = jet_term([flown(f"pair{k}", orbit(40.0, (0.6, 1.05), k), Wake(known), k) for k in range(2)])
    assert found is not None
    assert_within(found.values, "jet.push_mps2", float(push_in_table(known, np.array([0.4]), np.zeros(1))[0]))
    assert_within(found.values, "jet.travel_speed_mps", known.travel_speed_mps)
    assert_within(found.values, "jet.carried", known.carried)
    assert_within(found.values, "jet.slope", known.slope)
    other, rows = still_record("other", orbit(40.0, (0.6, 1.05), 9)), np.arange(4000)
    learned, true = (learned_downwash(other, 0, rows, jet, None) for jet in (found.term, known))
    assert np.mean((learned - true) ** 2) < 0.02 * np.mean(true**2)  # R2 0.98 on a flight of its own
    assert found.term.push_mps2.min() >= 0.0
    assert abs(found.term.upper_ratio) < 0.05  # the upper vehicle of these flights feels nothing


def test_the_values_reported_a_jet_are_those_of_its_term_and_within_the_search(
    pairs: list[AirRecord],
) -> None:
    found = jet_term([replace(one, measured=one.measured & (one.motion.t < 12.0)[:, None]) for one in pairs])
    assert found is not None
    values, term = {one.path: one for one in found.values}, found.term
    axis = float(push_in_table(term, np.array([0.4]), np.zeros(1))[0])
    assert values["jet.push_mps2"].value == axis
    for name, (low, high) in {
        "travel_speed_mps": (1.0, 1e3),
        "carried": (0.0, 1.5),
        "slope": (0.0, 1.5),
    }.items():
        one = values[f"jet.{name}"]
        assert one.value == getattr(term, name)
        assert one.ends is None or low <= one.ends[0] <= one.value <= one.ends[1] <= high, name
    assert values["jet.push_mps2"].ends is not None
    assert values["jet.push_mps2"].ends[0] < axis < values["jet.push_mps2"].ends[1]


def test_the_push_of_short_passes_is_whole_and_within_its_interval() -> None:
    """Of two minutes, 4.6 s are under the other vehicle: what pulls the push to zero shows most here."""
    flights = []
    for k in range(2):
        motion = orbit(60.0, (0.6, 1.05), k)
        pos = motion.pos * np.array([3.0, 3.0, 1.0])
        level = np.broadcast_to([0.0, 0.0, 1.0], pos.shape)
        wide = replace(motion, pos=pos, vel=np.gradient(pos, DT, axis=0), axis=level)
        flights.append(flown(f"passes{k}", wide, Wake(wide_jet()), k))
    found = jet_term(flights)
    assert found is not None
    push, known = found.values[0], float(push_in_table(wide_jet(), np.array([0.4]), np.zeros(1))[0])
    assert push.value == pytest.approx(known, rel=0.05)
    assert_within(found.values, "jet.push_mps2", known)
    assert push.ends is not None
    assert push.ends[0] < push.value < push.ends[1]


def test_travel_that_no_flight_shows_is_the_default_without_an_interval() -> None:
    """Sources that hover neither tilt nor move: where they were and what air they carried is not seen."""
    flights = []
    for k in range(2):
        motion = orbit(20.0, (0.6, 1.05), k)
        pos = motion.pos[:, ::-1].copy()  # now the lower one moves
        pos[..., 2] = [0.6, 1.05]
        up = np.broadcast_to([0.0, 0.0, 1.0], pos.shape).copy()
        still = replace(motion, pos=pos, vel=np.gradient(pos, DT, axis=0), axis=up)
        flights.append(flown(f"hovers{k}", still, Wake(wide_jet()), k))
    found = jet_term(flights)
    assert found is not None
    assert (found.term.travel_speed_mps, found.term.carried, found.term.slope) == (4.0, 0.8, 1.0)
    values = {one.path: one for one in found.values}
    for path in ("jet.travel_speed_mps", "jet.carried", "jet.slope"):
        assert values[path].ends is None
        assert values[path].source == "not shown by these flights: the default"
    known = float(push_in_table(wide_jet(), np.array([0.45]), np.zeros(1))[0])
    assert float(push_in_table(found.term, np.array([0.45]), np.zeros(1))[0]) == pytest.approx(
        known, rel=0.05
    )


def test_the_residual_is_found_under_the_noise_of_clear_air(pairs: list[AirRecord]) -> None:
    found = residual_term([HeldOutGroup(tuple(pairs), wide_jet())], None)
    assert found is not None
    assert_within(found.values, "residual.floor_mps2", RESIDUAL.floor_mps2)
    assert_within(found.values, "residual.slope", RESIDUAL.slope)
    assert_within(found.values, "residual.time_s", RESIDUAL.time_s)


def test_the_gains_of_vehicles_on_a_wake_are_told_from_their_errors() -> None:
    jet, flights = wide_jet(), []
    gains = 1.0 + 0.15 * np.random.default_rng(7).standard_normal(16)
    for k, gain in enumerate(gains):
        own = Wake(replace(jet, push_mps2=gain * jet.push_mps2), None, RESIDUAL)
        flights.append(flown(f"gain{k}", orbit(40.0, (0.6, 1.05), k), own, k))
    found = residual_term([HeldOutGroup(tuple(flights), jet)], None)
    same = residual_term([HeldOutGroup(tuple(flights[:1] * 4), jet)], None)
    assert found is not None
    assert same is not None
    gain = value(found.values, "residual.gain_std")
    assert gain.low is not None
    assert gain.high is not None
    assert gain.low < gains.std(ddof=1) < gain.high
    assert gain.high < 2.5 * gain.low  # 2.1 for 16 gains without errors
    assert_within(found.values, "residual.time_s", RESIDUAL.time_s)  # gains are taken out of the turbulence
    assert same.term.gain_std == 0.0  # one vehicle, seen four times


def test_flights_are_compared_with_the_jet_of_others(pairs: list[AirRecord]) -> None:
    groups = held_out_groups(pairs, wide_jet())
    assert [group.records for group in groups] == [(pairs[0],), (pairs[1],)]
    other = jet_alone(pairs[1:])
    assert other is not None
    np.testing.assert_array_equal(groups[0].jet.push_mps2, other.push_mps2)
    (alone,) = held_out_groups(pairs[:1], wide_jet())
    np.testing.assert_array_equal(alone.jet.push_mps2, wide_jet().push_mps2)  # nobody else shows one


def test_what_a_vehicle_absorbs_is_found_from_three_above_each_other() -> None:
    wake = Wake(wide_jet(), ABSORPTION)
    triples = [flown(f"triple{k}", orbit(2.0 * SECONDS, (0.6, 0.9, 1.25), k), wake, k) for k in range(2)]
    found, both = absorption_term(triples, wake.jet), sum_of_two(triples, wake.jet)
    assert found is not None
    assert both is not None
    assert_within(found.values, "absorption.share", ABSORPTION.share)
    assert abs(found.term.width_m - ABSORPTION.width_m) <= 0.04  # two steps of the grid
    assert both.value < 0.95
    no_push = replace(wake.jet, push_mps2=0.0 * wake.jet.push_mps2)
    assert sum_of_two(triples, no_push) is None


def test_the_torque_at_the_edge_is_found_from_what_the_motors_do_against_it() -> None:
    jet, peak, radius = wide_jet(), 0.0015, 0.06
    motion = orbit(SECONDS, (0.6, 1.05), 3)
    record = still_record("edge", motion)
    place = jet_place(record, (0, 1), np.arange(motion.t.size), Travel(0.25, 0.8, 1.0))
    size = peak * place.radius / radius * np.exp(0.5 * (1.0 - (place.radius / radius) ** 2))
    size[place.gap < 0.05] = 0.0
    wake = size[:, None] * np.stack([-place.toward[:, 1], place.toward[:, 0]], axis=1)  # about e_z x n
    lever, weight = CRAZYFLIE_2_0.arm / np.sqrt(2.0), CRAZYFLIE_2_0.hover_thrust
    power = USUAL_POWER
    share = -(wake[:, :1] * ROLL + wake[:, 1:] * PITCH) / (lever * weight * power)  # of four rotors' duty
    duty = np.full((motion.t.size, 2, 4), 0.65)
    duty[:, 0] *= 1.0 + share
    short = replace(record, lag=0.0, motors=Motors(duty, np.full(duty.shape[:2], np.nan)))
    found = edge_torque_term([with_push(short, np.zeros(duty.shape[:2]))], jet, CRAZYFLIE_2_0)
    assert found is not None
    assert found.term.peak_nm == pytest.approx(peak, rel=0.02)
    assert found.term.radius_m == pytest.approx(radius, abs=0.005)


def test_the_ground_effect_is_found_from_a_flight_close_to_the_ground() -> None:
    t = np.arange(0.0, 60.0, DT)
    pos = np.zeros((t.size, 1, 3))
    pos[:, 0, 2] = 0.27 + 0.2 * np.sin(0.5 * t)
    record = still_record(
        "ground", Motion(t, pos, np.gradient(pos, DT, axis=0), np.eye(3)[[2]][None] + 0.0 * pos)
    )
    gain = 1.0 + 0.7 * (ROTOR_RADIUS / np.maximum(pos[:, :, 2], ROTOR_RADIUS)) ** 2
    noisy = record.specific_force.copy()
    noisy[..., 2] = GRAVITY * gain + 0.2 * np.random.default_rng(0).standard_normal(gain.shape)
    found = ground_term([replace(record, specific_force=noisy)])
    assert_within(found.values, "ground.coefficient", 0.7)


def test_without_a_flight_near_the_ground_the_published_effect_is_named() -> None:
    found = ground_term([still_record("high", orbit(20.0, (0.6,), 0))])
    assert found.term.coefficient == ONE_ROTOR
    assert found.values[0].low is None
    assert "not learned" in found.values[0].source


def test_gusts_are_told_from_noise_by_their_time() -> None:
    rng = np.random.default_rng(5)
    records = []
    for k in range(9):
        motion = orbit(40.0, (0.6,), k)
        noise = 0.2 * rng.standard_normal((motion.t.size, 1))
        gust = 0.15 * process(motion.t.size, 0.3, rng)
        records.append(with_push(still_record(f"clear{k}", motion), noise + gust[:, None]))
    found = wind_term(records)
    assert found is not None
    assert_within(found.values, "wind.gust_std_mps2", 0.15)
    assert_within(found.values, "wind.gust_time_s", 0.3)
