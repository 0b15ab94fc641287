"""Tests of the jets in a room: each term against its closed form, and the kernel against plain numpy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from room_air_twin import resting_push
from room_flights import GAPS, HOVER, JET, PUSH, RADII, hover, swarm_in

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.air.air_terms import AbsorptionTerm, EdgeTorqueTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.state_row import POS, QUAT, ROTORS, TORQUE, TX, TY, VEL
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm


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
        swarm = swarm_in(air, [tuple(place) for place in places])
        tilt = rng.uniform(-0.3, 0.3, (3, 6))
        swarm.state[:, QUAT] = quat_from_euler(*tilt)
        thrust_ratio = rng.uniform(0.5, 1.5, 6)
        swarm.state[:, ROTORS] = 0.25 * HOVER * thrust_ratio[:, None]
        expected = resting_push(air, places, swarm.state[:, QUAT], thrust_ratio)
        _remember_for_ever(swarm, thrust_ratio)
        np.testing.assert_allclose(swarm.downwash(), expected.acc, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(swarm.state[:, TORQUE], expected.torque, rtol=1e-9, atol=1e-15)
        found = max(found, np.abs(expected.torque[:, 2]).max())
    assert found > 1e-5  # tilted vehicles feel part of it about their yaw axis


def _remember_for_ever(swarm: Swarm, thrust_ratio: Array) -> None:
    """Write the present into all of the past, at rest."""
    x, y, z, w = swarm.state[:, QUAT].T
    upright = 1.0 - 2.0 * (x * x + y * y)
    swarm.air.ring[:, :, 3] = thrust_ratio
    swarm.air.ring[:, :, 6] = 2.0 * (x * z + w * y) / upright
    swarm.air.ring[:, :, 7] = 2.0 * (y * z - w * x) / upright


def test_at_the_nodes_of_the_table_the_push_is_the_tables() -> None:
    for a, gap in enumerate(GAPS):
        for b, radius in enumerate(RADII[:-1]):
            eta = swarm_in(RoomAir(jet=JET), [(0.0, 0.0, 1.0), (radius, 0.0, 1.0 + gap)]).downwash()[:, 2]
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

    swarm = swarm_in(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 1.0)])
    # 1 mm of a profile whose cells are 2 cm wide
    assert momentum(1.6) == pytest.approx(momentum(0.8), rel=2e-3)
    assert momentum(2.4) == pytest.approx(momentum(0.8), rel=2e-3)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.9])
def test_no_more_than_two_weights_of_momentum_arrive_below_a_stack_of_three(share: float) -> None:
    # the middle vehicle hovers: it carries its weight and the push on it
    air = RoomAir(jet=replace(JET, upper_ratio=0.0), absorption=AbsorptionTerm(max(share, 1e-9), 0.05))
    swarm = swarm_in(air, [(0.0, 0.0, 0.5), (0.0, 0.0, 0.9), (0.0, 0.0, 1.3)])
    on_middle = -swarm.downwash()[1, 2] / GRAVITY
    swarm.state[1, ROTORS] *= 1.0 + on_middle
    swarm.air.ring[:, 1, 3] = 1.0 + on_middle
    middle = swarm_in(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 0.9)]).downwash()[0, 2]
    top = swarm_in(RoomAir(jet=JET), [(0.0, 0.0, 0.5), (0.0, 0.0, 1.3)]).downwash()[0, 2]
    left = (swarm.downwash()[0, 2] - (1.0 + on_middle) * middle) / top  # of the top vehicle's jet
    assert 1.0 + on_middle + left <= 2.0 + 1e-9
    assert left == pytest.approx(1.0 - max(share, on_middle), abs=1e-6)


def test_without_absorption_two_jets_add_up() -> None:
    places = [(0.0, 0.0, 0.5), (0.02, 0.0, 0.9), (0.0, 0.03, 1.3)]
    both = swarm_in(RoomAir(jet=JET), places).downwash()[0, 2]
    each = [swarm_in(RoomAir(jet=JET), [places[0], other]).downwash()[0, 2] for other in places[1:]]
    assert both == pytest.approx(sum(each), rel=1e-12)


def test_the_jet_arrives_late_by_its_way_over_its_speed() -> None:
    swarm = swarm_in(RoomAir(jet=JET), [(0.0, 0.0, 1.0), (0.0, 0.0, 1.75)])
    before = swarm.downwash()[0, 2]
    swarm.state[1, 3] = 0.3 * PHYSICS_RATE  # the source flies 0.3 m aside in one step, and stops
    hover(swarm, 1)
    assert swarm.state[1, 0] == pytest.approx(0.3, rel=0.01)
    swarm.state[1, 3] = 0.0
    late = []
    for _ in range(80):
        hover(swarm, 1)
        late.append(swarm.downwash()[0, 2] < 0.5 * before)
    assert before < -1.0
    assert sum(late) / PHYSICS_RATE == pytest.approx(0.75 / 7.5, abs=2.0 / PHYSICS_RATE)
    assert not late[-1]


def test_a_carried_jet_goes_on_with_the_velocity_of_its_source() -> None:
    # the source flies past at constant speed: a jet that keeps it stays below, another lies behind
    def peak(carried: float) -> float:
        swarm = swarm_in(RoomAir(jet=replace(JET, carried=carried)), [(0.0, 0.0, 1.0), (-0.5, 0.0, 1.6)])
        places, pushes = [], []
        for k in range(600):
            swarm.state[0, POS], swarm.state[0, VEL] = [0.0, 0.0, 1.0], 0.0
            swarm.state[1, POS], swarm.state[1, VEL] = [-0.5 + 0.002 * k, 0.0, 1.6], [1.0, 0.0, 0.0]
            hover(swarm, 1)
            places.append(swarm.state[1, 0])
            pushes.append(swarm.downwash()[0, 2])
        return places[int(np.argmin(pushes))]

    assert peak(1.0) == pytest.approx(0.0, abs=0.005)
    assert peak(0.0) == pytest.approx(1.0 * 0.6 / 7.5, abs=0.005)  # flown on by v dz / speed


def test_the_jet_leaves_along_the_tilted_source() -> None:
    # a source tilted towards +x thrusts towards +x and blows towards -x
    def push(x: float) -> float:
        swarm = swarm_in(RoomAir(jet=replace(JET, slope=1.0)), [(x, 0.0, 1.0), (0.0, 0.0, 1.5)])
        swarm.state[1, QUAT] = quat_from_euler(0.0, 0.1, 0.0)
        _remember_for_ever(swarm, np.ones(2))
        return -float(swarm.downwash()[0, 2])

    # 5 cm towards -x at dz = 0.5 m
    assert push(-0.05) == pytest.approx(np.interp(abs(0.05 - 0.5 * math.tan(0.1)), RADII, PUSH[3]), rel=1e-9)
    assert push(0.05) == pytest.approx(np.interp(0.05 + 0.5 * math.tan(0.1), RADII, PUSH[3]), rel=1e-9)


def test_the_edge_torque_is_the_closed_form_and_tips_towards_the_axis() -> None:
    air = RoomAir(jet=JET, edge_torque=EdgeTorqueTerm(peak_nm=2e-3, radius_m=0.06))
    for radius in (0.03, 0.06, 0.09, 0.13):
        swarm = swarm_in(air, [(radius, 0.0, 1.0), (0.0, 0.0, 1.5)])
        swarm.downwash()
        ratio = radius / 0.06
        size = 2e-3 * ratio * math.exp(0.5 * (1.0 - ratio**2))
        # beside the axis on +x: the vehicle pitches so that its thrust points to -x, a negative pitch
        np.testing.assert_allclose(swarm.state[0, TORQUE], [0.0, -size, 0.0], rtol=1e-9, atol=1e-15)
    swarm = swarm_in(air, [(0.06, 0.0, 1.0), (0.0, 0.0, 1.5)])
    hover(swarm, 5)
    assert swarm.state[0, 3] <= 0.0
    assert swarm.state[0, 11] < 0.0  # pitch rate


def test_the_torque_turns_the_body_by_its_inertia() -> None:
    swarm = Swarm(("cf1",), CRAZYFLIE_2_0, np.array([[0.0, 0.0, 1.0, 0.0]]), WakeLaw.NONE)
    swarm.state[0, ROTORS] = 0.0
    swarm.state[0, [TX, TY]] = 2e-6, -1e-6
    swarm.step(np.zeros((10, 1, 4)), np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
    ix, iy, _ = CRAZYFLIE_2_0.inertia
    np.testing.assert_allclose(swarm.state[0, 10:12], [2e-6 * 0.02 / ix, -1e-6 * 0.02 / iy], rtol=1e-9)
