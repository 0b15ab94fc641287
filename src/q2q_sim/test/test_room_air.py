"""Tests of the air of a room: every term against its closed form, and the kernel against plain numpy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from room_air_twin import deviation, resting_push

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.air.room_air import (
    TERMS,
    AbsorptionTerm,
    EdgeTorqueTerm,
    GroundTerm,
    JetTerm,
    MeanderTerm,
    RateLoadTerm,
    ResidualTerm,
    RoomAir,
    RotorDragTerm,
    VehicleTerm,
    WindTerm,
    without,
)
from q2q_sim.air.unit_processes import RESIDUAL, OrnsteinUhlenbeck, PlayedBack
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.loop.scenario_air import ambient_of_air
from q2q_sim.plant.quadcopter import CEILING1, ETA, POS, QUAT, RATE, ROTORS, TORQUE, TX, TY, VEL
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm

GAPS = np.array([0.1, 0.2, 0.35, 0.5, 0.8])
RADII = np.array([0.0, 0.02, 0.05, 0.08, 0.12, 0.2])
PUSH = 2.5 * np.exp(-0.95 * (GAPS[:, None] - 0.4) - 0.5 * (RADII / 0.054) ** 2)
PUSH[:, -1] = 0.0
JET = JetTerm(GAPS, RADII, PUSH, upper_ratio=0.02, travel_speed_mps=7.5, carried=0.0, slope=0.0)
HOVER = CRAZYFLIE_2_0.hover_thrust
MASS = CRAZYFLIE_2_0.mass
SMALL = AbsorptionTerm(share=0.05, width_m=0.05)


def _swarm(air: RoomAir, places: list[tuple[float, float, float]], seed: int = 0) -> Swarm:
    start = np.array([[*place, 0.0] for place in places])
    return Swarm(tuple(f"cf{i}" for i in range(len(places))), CRAZYFLIE_2_0, start, air, seed)


def _hover(swarm: Swarm, steps: int) -> None:
    n = len(swarm.names)
    drive = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], (n, 1))
    swarm.step(np.tile([HOVER, 0.0, 0.0, 0.0], (steps, n, 1)), drive)


def _held(swarm: Swarm, steps: int) -> Array:
    """Return the push on vehicles that are put back to their start after each step, (steps, n)."""
    start, pushes = swarm.state.copy(), []
    for _ in range(steps):
        pushes.append(swarm.downwash()[:, 2])
        _hover(swarm, 1)
        swarm.state[:, :ETA] = start[:, :ETA]
    return np.array(pushes)


def test_the_kernel_gives_what_plain_numpy_does() -> None:
    rng = np.random.default_rng(5)
    air = RoomAir(
        jet=replace(JET, slope=0.7, bend=(0.1, -0.05)),
        absorption=AbsorptionTerm(0.3, 0.06),
        edge_torque=EdgeTorqueTerm(2e-3, 0.06),
    )
    found = 0.0
    for _ in range(20):
        places = np.column_stack([rng.uniform(0.0, 0.25, (6, 2)), rng.uniform(0.3, 2.2, 6)])
        swarm = _swarm(air, [tuple(place) for place in places])
        tilt = rng.uniform(-0.3, 0.3, (3, 6))
        swarm.state[:, QUAT] = quat_from_euler(*tilt)
        share = rng.uniform(0.5, 1.5, 6)
        swarm.state[:, ROTORS] = 0.25 * HOVER * share[:, None]
        expected = resting_push(air, places, swarm.state[:, QUAT], share)
        _remember_for_ever(swarm, share)
        np.testing.assert_allclose(swarm.downwash(), expected.acc, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(swarm.state[:, TORQUE], expected.torque, rtol=1e-9, atol=1e-15)
        found = max(found, np.abs(expected.torque[:, 2]).max())
    assert found > 1e-5  # tilted vehicles feel part of it about their yaw axis


def _remember_for_ever(swarm: Swarm, share: Array) -> None:
    """Write the present into all of the past, at rest."""
    x, y, z, w = swarm.state[:, QUAT].T
    upright = 1.0 - 2.0 * (x * x + y * y)
    swarm.air.ring[:, :, 3] = share
    swarm.air.ring[:, :, 6] = 2.0 * (x * z + w * y) / upright
    swarm.air.ring[:, :, 7] = 2.0 * (y * z - w * x) / upright


def test_at_the_nodes_of_the_table_the_push_is_the_tables() -> None:
    for a, gap in enumerate(GAPS):
        for b, radius in enumerate(RADII[:-1]):
            eta = _swarm(RoomAir(jet=JET), [(0.0, 0.0, 1.0), (radius, 0.0, 1.0 + gap)]).downwash()[:, 2]
            along = min(0.5 * (gap / 0.1 + 1.0), 1.0)
            weight = along**2 * (3.0 - 2.0 * along)
            np.testing.assert_allclose(eta, PUSH[a, b] * weight * np.array([-1.0, 0.02]), rtol=1e-9)


def test_below_the_table_the_jet_keeps_its_momentum() -> None:
    # self-similar: the push integrated over a horizontal plane is the same at every height
    def momentum(gap: float) -> float:
        radii = np.linspace(0.0, 1.2, 1201)
        push = [-_pair(gap, radius) for radius in radii]
        return float(np.trapezoid(2.0 * np.pi * radii * push, radii))

    def _pair(gap: float, radius: float) -> float:
        swarm.state[1, :3] = radius, 0.0, 0.5 + gap
        swarm.air.ring[:, 1, :3] = swarm.state[1, :3]
        return float(swarm.downwash()[0, 2])

    swarm = _swarm(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 1.0)])
    # 1 mm of a profile whose cells are 2 cm wide
    assert momentum(1.6) == pytest.approx(momentum(0.8), rel=2e-3)
    assert momentum(2.4) == pytest.approx(momentum(0.8), rel=2e-3)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.9])
def test_no_more_than_two_weights_of_momentum_arrive_below_a_stack_of_three(share: float) -> None:
    # the middle vehicle hovers: it carries its weight and the push on it
    air = RoomAir(jet=replace(JET, upper_ratio=0.0), absorption=AbsorptionTerm(max(share, 1e-9), 0.05))
    swarm = _swarm(air, [(0.0, 0.0, 0.5), (0.0, 0.0, 0.9), (0.0, 0.0, 1.3)])
    on_middle = -swarm.downwash()[1, 2] / GRAVITY
    swarm.state[1, ROTORS] *= 1.0 + on_middle
    swarm.air.ring[:, 1, 3] = 1.0 + on_middle
    middle = _swarm(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 0.9)]).downwash()[0, 2]
    top = _swarm(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 1.3)]).downwash()[0, 2]
    left = (swarm.downwash()[0, 2] - (1.0 + on_middle) * middle) / top  # of the top vehicle's jet
    assert 1.0 + on_middle + left <= 2.0 + 1e-9
    assert left == pytest.approx(1.0 - max(share, on_middle), abs=1e-6)


def test_without_absorption_two_jets_add_up() -> None:
    places = [(0.0, 0.0, 0.5), (0.02, 0.0, 0.9), (0.0, 0.03, 1.3)]
    both = _swarm(RoomAir(jet=JET), places).downwash()[0, 2]
    each = [_swarm(RoomAir(jet=JET), [places[0], other]).downwash()[0, 2] for other in places[1:]]
    assert both == pytest.approx(sum(each), rel=1e-12)


def test_the_jet_arrives_late_by_its_way_over_its_speed() -> None:
    swarm = _swarm(RoomAir(jet=JET), [(0.0, 0.0, 1.0), (0.0, 0.0, 1.75)])
    before = swarm.downwash()[0, 2]
    swarm.state[1, 3] = 0.3 * PHYSICS_RATE  # the source flies 0.3 m aside in one step, and stops
    _hover(swarm, 1)
    assert swarm.state[1, 0] == pytest.approx(0.3, rel=0.01)
    swarm.state[1, 3] = 0.0
    late = []
    for _ in range(80):
        _hover(swarm, 1)
        late.append(swarm.downwash()[0, 2] < 0.5 * before)
    assert before < -1.0
    assert sum(late) / PHYSICS_RATE == pytest.approx(0.75 / 7.5, abs=2.0 / PHYSICS_RATE)
    assert not late[-1]


def test_a_carried_jet_goes_on_with_the_velocity_of_its_source() -> None:
    # the source flies past at constant speed: a jet that keeps it stays below, another lies behind
    def peak(carried: float) -> float:
        swarm = _swarm(RoomAir(jet=replace(JET, carried=carried)), [(0.0, 0.0, 1.0), (-0.5, 0.0, 1.6)])
        places, pushes = [], []
        for k in range(600):
            swarm.state[0, POS], swarm.state[0, VEL] = [0.0, 0.0, 1.0], 0.0
            swarm.state[1, POS], swarm.state[1, VEL] = [-0.5 + 0.002 * k, 0.0, 1.6], [1.0, 0.0, 0.0]
            _hover(swarm, 1)
            places.append(swarm.state[1, 0])
            pushes.append(swarm.downwash()[0, 2])
        return places[int(np.argmin(pushes))]

    assert peak(1.0) == pytest.approx(0.0, abs=0.005)
    assert peak(0.0) == pytest.approx(1.0 * 0.6 / 7.5, abs=0.005)  # flown on by v dz / speed


def test_the_jet_leaves_along_the_tilted_source() -> None:
    # a source tilted towards +x thrusts towards +x and blows towards -x
    def push(x: float) -> float:
        swarm = _swarm(RoomAir(jet=replace(JET, slope=1.0)), [(x, 0.0, 1.0), (0.0, 0.0, 1.5)])
        swarm.state[1, QUAT] = quat_from_euler(0.0, 0.1, 0.0)
        _remember_for_ever(swarm, np.ones(2))
        return -float(swarm.downwash()[0, 2])

    # 5 cm towards -x at dz = 0.5 m
    assert push(-0.05) == pytest.approx(np.interp(abs(0.05 - 0.5 * math.tan(0.1)), RADII, PUSH[3]), rel=1e-9)
    assert push(0.05) == pytest.approx(np.interp(0.05 + 0.5 * math.tan(0.1), RADII, PUSH[3]), rel=1e-9)


def test_the_edge_torque_is_the_closed_form_and_tips_towards_the_axis() -> None:
    air = RoomAir(jet=JET, edge_torque=EdgeTorqueTerm(peak_nm=2e-3, radius_m=0.06))
    for radius in (0.03, 0.06, 0.09, 0.13):
        swarm = _swarm(air, [(radius, 0.0, 1.0), (0.0, 0.0, 1.5)])
        swarm.downwash()
        ratio = radius / 0.06
        size = 2e-3 * ratio * math.exp(0.5 * (1.0 - ratio**2))
        # beside the axis on +x: the vehicle pitches so that its thrust points to -x, a negative pitch
        np.testing.assert_allclose(swarm.state[0, TORQUE], [0.0, -size, 0.0], rtol=1e-9, atol=1e-15)
    swarm = _swarm(air, [(0.06, 0.0, 1.0), (0.0, 0.0, 1.5)])
    _hover(swarm, 5)
    assert swarm.state[0, 3] <= 0.0
    assert swarm.state[0, 11] < 0.0  # pitch rate


def test_the_torque_turns_the_body_by_its_inertia() -> None:
    swarm = Swarm(("cf1",), CRAZYFLIE_2_0, np.array([[0.0, 0.0, 1.0, 0.0]]), WakeLaw.NONE)
    swarm.state[0, ROTORS] = 0.0
    swarm.state[0, [TX, TY]] = 2e-6, -1e-6
    swarm.step(np.zeros((10, 1, 4)), np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
    ix, iy, _ = CRAZYFLIE_2_0.inertia
    np.testing.assert_allclose(swarm.state[0, 10:12], [2e-6 * 0.02 / ix, -1e-6 * 0.02 / iy], rtol=1e-9)


def test_ground_effect_multiplies_the_thrust() -> None:
    air = RoomAir(ground=GroundTerm(coefficient=0.5, rotor_radius_m=0.023))
    for z in (0.03, 0.1, 0.5):
        eta = _swarm(air, [(0.0, 0.0, z)]).downwash()[0]
        np.testing.assert_allclose(eta, [0.0, 0.0, 0.5 * (0.023 / z) ** 2 * GRAVITY], rtol=1e-9)
    on_ground = _swarm(air, [(0.0, 0.0, 0.01)]).downwash()[0, 2]
    assert on_ground == pytest.approx(0.5 * GRAVITY, rel=1e-9)  # no nearer than one radius


def test_the_residual_has_its_size_and_correlation() -> None:
    air = RoomAir(jet=JET, residual=ResidualTerm(floor_mps2=0.28, slope=0.1, time_s=0.08))
    places = [place for k in range(100) for place in ((3.0 * k, 0.0, 1.0), (3.0 * k, 0.0, 1.5))]
    swarm = _swarm(air, places, seed=4)
    pushes = _held(swarm, 2 * PHYSICS_RATE)
    mean = _swarm(RoomAir(jet=JET), places).downwash()[:, 2]
    rest = (pushes - mean)[:, ::2]
    size = deviation(air, mean)[0]
    assert size == pytest.approx(0.28 + 0.1 * -mean[0])
    # 100 processes of 2 s with 0.08 s of correlation: 1250 independent values, 2 % of their deviation
    assert rest.std() == pytest.approx(size, rel=0.08)
    lagged = (rest[40:] * rest[:-40]).mean() / (rest * rest).mean()
    assert lagged == pytest.approx(math.exp(-1.0), abs=0.1)


def test_the_unit_process_goes_on_across_blocks() -> None:
    step, time = 0.002, 0.08
    drawn = OrnsteinUhlenbeck(np.random.default_rng(1), 400, step, time)
    values = np.concatenate([drawn.block(10) for _ in range(20)])
    across = (values[9::10][:-1] * values[10::10]).mean() / (values * values).mean()
    assert across == pytest.approx(math.exp(-step / time), abs=0.02)
    assert values.std() == pytest.approx(1.0, abs=0.05)


def test_a_recording_is_cut_and_pasted_with_its_variance() -> None:
    rng = np.random.default_rng(2)
    recording = np.convolve(rng.standard_normal(6000), np.ones(5) / math.sqrt(5.0), mode="valid")
    played = PlayedBack(rng, 50, 0.002, recording)
    values = np.concatenate([played.block(500) for _ in range(6)])
    # between samples of a process with correlation 0.8 linear interpolation loses 2/3 of 0.2 of the variance
    assert values.std() == pytest.approx(recording.std(), rel=0.1)
    assert np.abs(np.diff(values, axis=0)).max() < 1.0  # no jump where pieces meet
    assert np.ptp(values[:, 0] - values[:, 1]) > 1.0  # vehicles play different pieces


def test_the_ceiling_of_thrust_falls_with_the_battery() -> None:
    own = VehicleTerm(0.0, 0.0, thrust_lag_s=0.01, headroom=1.2, headroom_per_volt=0.5, discharge_v_per_s=0.2)
    swarm = _swarm(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    drive = np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]])
    full = np.tile([2.0 * HOVER, 0.0, 0.0, 0.0], (PHYSICS_RATE, 1, 1))
    swarm.step(full, drive)
    # follows 1.2 - 0.1 t with 0.01 s of lag, so by 0.001 above it
    assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(1.1 + 0.001, abs=3e-4)


def test_a_rooms_thrust_lag_replaces_the_vehicles() -> None:
    own = VehicleTerm(0.0, 0.0, 0.04, headroom=9.0, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    swarm = _swarm(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    command = np.tile([1.2 * HOVER, 0.0, 0.0, 0.0], (20, 1, 1))
    swarm.step(command, np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
    assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(1.2 - 0.2 * math.exp(-1.0), rel=1e-6)


def test_motors_of_a_room_give_all_of_their_headroom() -> None:
    own = VehicleTerm(0.0, 0.0, 0.01, headroom=1.8, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    swarm = _swarm(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    for asked, given in ((1.7, 1.7), (2.5, 1.8)):  # the vehicle's own limit is below 1.7
        command = np.tile([asked * HOVER, 0.0, 0.0, 0.0], (PHYSICS_RATE, 1, 1))
        swarm.step(command, np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
        assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(given, rel=1e-9)


def test_the_headroom_differs_between_vehicles_by_its_deviation() -> None:
    own = VehicleTerm(0.0, 0.0, 0.05, 1.8, 0.0, 0.0, headroom_std=0.1)
    swarm = _swarm(RoomAir(vehicle=own), [(float(k), 0.0, 1.0) for k in range(1000)])
    swarm.downwash()
    headroom = 4.0 * swarm.state[:, CEILING1] / HOVER
    assert headroom.mean() == pytest.approx(1.8, abs=5.0 * 0.1 / np.sqrt(1000.0))
    assert headroom.std() == pytest.approx(0.1, rel=0.11)  # five deviations


def test_the_motors_of_a_vehicle_differ_by_their_deviation() -> None:
    own = VehicleTerm(0.0, 0.0, 0.05, 1.8, 0.0, 0.0, motor_std=0.08)
    swarm = _swarm(RoomAir(vehicle=own), [(float(k), 0.0, 1.0) for k in range(1000)])
    swarm.downwash()
    work = 1.8 * 0.25 * HOVER / swarm.state[:, CEILING1:]  # what each works at hover, over their mean
    np.testing.assert_allclose(work.mean(axis=1), 1.0)
    assert np.sqrt(((work - 1.0) ** 2).sum() / 3000.0) == pytest.approx(0.08, rel=0.07)  # five deviations


def test_turning_takes_from_the_range_of_the_rotors_that_turn_the_vehicle() -> None:
    own = VehicleTerm(0.0, 0.0, 0.07, 1.8, 0.0, 0.0)
    swarm = _swarm(RoomAir(vehicle=own, rate_load=RateLoadTerm(3e-3)), [(0.0, 0.0, 1.0), (2.0, 0.0, 1.0)])
    swarm.state[0, RATE] = [0.5, -0.2, 1.0]
    swarm.state[1, ROTORS] = 0.25 * HOVER + np.array([-0.01, -0.01, 0.01, 0.01])  # rolls faster and faster
    swarm.downwash()
    lever = CRAZYFLIE_2_0.arm / math.sqrt(2.0)
    free, each = 0.25 * 1.8 * HOVER, 3e-3 / (4.0 * lever)
    roll, pitch = np.array([-1.0, -1.0, 1.0, 1.0]), np.array([-1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(swarm.state[0, CEILING1:], free - each * (0.5 * roll - 0.2 * pitch))
    ahead = 0.07 * lever * 0.04 / CRAZYFLIE_2_0.inertia[0]  # of the rate, after the lag of the thrust
    np.testing.assert_allclose(swarm.state[1, CEILING1:], free - each * ahead * roll)


def test_each_vehicle_feels_a_wake_by_its_own_gain() -> None:
    places = [(3.0 * k, 0.0, z) for k in range(400) for z in (0.6, 1.0)]
    swarm = _swarm(RoomAir(jet=JET, residual=ResidualTerm(0.0, 0.0, 0.1, gain_std=0.15)), places)
    mean = _swarm(RoomAir(jet=JET), places).downwash()[::2, 2]
    gain = swarm.downwash()[::2, 2] / mean
    assert gain.mean() == pytest.approx(1.0, abs=5.0 * 0.15 / 20.0)
    assert gain.std() == pytest.approx(0.15, rel=0.18)  # five deviations


def test_rotor_drag_slows_across_the_thrust_alone() -> None:
    swarm = _swarm(RoomAir(rotor_drag=RotorDragTerm(0.4)), [(0.0, 0.0, 1.0), (2.0, 0.0, 1.0)])
    tilt = 0.3
    swarm.state[1, QUAT] = quat_from_euler(0.0, tilt, 0.0)
    swarm.state[:, VEL] = [1.0, -0.5, 0.2]
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    across = np.array([1.0, -0.5, 0.2]) - axis * (axis @ [1.0, -0.5, 0.2])
    np.testing.assert_allclose(swarm.downwash(), -0.4 * np.array([[1.0, -0.5, 0.0], across]), atol=1e-12)


def test_wind_and_offsets_have_their_sizes() -> None:
    own = VehicleTerm(0.2, 0.1, 0.07, headroom=2.0, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    air = RoomAir(wind=WindTerm((0.3, -0.2, 0.1), gust_std_mps2=0.05, gust_time_s=0.2), vehicle=own)
    ambient = ambient_of_air(air, 2000, 0.01, seed=3)
    pushes = np.array([ambient.drive()[:, :3] for _ in range(50)])
    # 2000 draws: 2 % of a deviation for the mean, 1.6 % for the deviation; five times that
    np.testing.assert_allclose(pushes.mean(axis=(0, 1)), [0.3, -0.2, 0.1 + 0.2], atol=0.012)
    np.testing.assert_allclose(pushes[..., :2].std(axis=(0, 1)), 0.05, rtol=0.08)
    assert ambient.offset.std() == pytest.approx(0.1, rel=0.08)
    assert np.abs(ambient.push(np.zeros((2000, 3))).mean(axis=0)[2] - 0.1) < 0.01  # offsets are no air


WHOLE = RoomAir(
    jet=JET,
    absorption=AbsorptionTerm(0.3, 0.06),
    meander=MeanderTerm(0.04, 0.3),
    residual=ResidualTerm(0.28, 0.1, 0.08),
    edge_torque=EdgeTorqueTerm(2e-3, 0.06),
    ground=GroundTerm(0.5, 0.023),
    wind=WindTerm((0.1, 0.0, 0.0), 0.05, 1.0),
    vehicle=VehicleTerm(0.1, 0.1, 0.06, 1.5, 0.1, 0.001),
    rotor_drag=RotorDragTerm(0.44),
    rate_load=RateLoadTerm(0.05),
)


def _flown(air: RoomAir, seed: int, pieces: tuple[int, ...]) -> Array:
    swarm = _swarm(air, [(0.0, 0.0, 0.6), (0.04, 0.0, 1.0), (0.0, 0.05, 1.4)], seed)
    for steps in pieces:
        _hover(swarm, steps)
    return swarm.state[:, :ETA]


def test_the_same_seed_gives_the_same_flight_however_it_is_cut() -> None:
    one = _flown(WHOLE, 7, (1200,))
    np.testing.assert_array_equal(one, _flown(WHOLE, 7, (3, 600, 597)))
    assert np.abs(one - _flown(WHOLE, 8, (1200,))).max() > 1e-3


@pytest.mark.parametrize("term", [term for term in TERMS if term != "wind"])
def test_every_term_moves_the_vehicles_and_none_is_left_when_all_are_off(term: str) -> None:
    assert np.abs(_flown(WHOLE, 7, (200,)) - _flown(without(WHOLE, (term,)), 7, (200,))).max() > 1e-7


def test_an_air_without_terms_is_still_air() -> None:
    off = without(WHOLE, TERMS)
    assert off == RoomAir()
    start = np.array([[0.0, 0.0, 0.6, 0.0], [0.04, 0.0, 1.0, 0.0], [0.0, 0.05, 1.4, 0.0]])
    still = Swarm(("a", "b", "c"), CRAZYFLIE_2_0, start, WakeLaw.NONE)
    _hover(still, 200)
    np.testing.assert_array_equal(_flown(off, 7, (200,)), still.state[:, :ETA])


def test_switching_a_term_off_leaves_the_draws_of_the_others() -> None:
    swarms = [_swarm(air, [(0.0, 0.0, 1.0)], 5) for air in (WHOLE, without(WHOLE, ("meander", "wind")))]
    units = [swarm.air.room.unit for swarm in swarms if swarm.prepare()]
    np.testing.assert_array_equal(units[0][RESIDUAL], units[1][RESIDUAL])
    assert units[0].std() > 0.5
