"""A recorded flight is flown again by its own law, and its air is distinguished from another one."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.geometry.rotations import UP, identity_quat, rotate
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushRecord, scored_rows
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_terms import RotorDragTerm, VehicleTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.experiments.validation.comparison import comparison
from q2q_sim.experiments.validation.drawn_air import Draw, MakeDraw, draws_in
from q2q_sim.experiments.validation.error_figures import error_figure
from q2q_sim.experiments.validation.estimate_noise import estimate_noise
from q2q_sim.experiments.validation.recorded_law import LOOP, ReadFlight, RecordedLaw, check_stable, read_law
from q2q_sim.experiments.validation.redrawn_flight import redraw_flight
from q2q_sim.experiments.validation.rotor_drag import drag_acceleration, read_drag
from q2q_sim.experiments.validation.tracked_flight import TrackedFlight
from q2q_sim.experiments.validation.validate_flights import _all_flown
from q2q_sim.experiments.validation.validation import (
    COVERAGE,
    RMS_RATIO,
    ValidatedFlight,
    as_json,
    pooled_comparison,
    validate_flight,
    validation_sentence,
)
from q2q_sim.experiments.validation.validation_replay import longest_under_wake, replayed_runs
from q2q_sim.plant.body.state_row import VEL
from q2q_sim.plant.disturbance import Disturbance, DisturbanceParams
from q2q_sim.plant.swarm import Swarm

DT = 0.01
NAMES = ("cf1", "cf2")
LAW = RecordedLaw(
    k_p=np.array([20.0, 20.0, 10.0]),
    k_d=np.array([10.0, 10.0, 5.0]),
    k_i=np.array([0.6, 0.6, 0.6]),
    offset=np.zeros((2, 3)),
    rms=0.0,
    attitude=replace(LOOP, frequency=60.0),
)
TURBULENCE, MEMORY = 0.15, 0.9
"""Standard deviation of the turbulence [m/s^2], and what is left of it after 10 ms: 0.1 s."""


class Turbulent(Swarm):
    """Swarm in `strength` times the measured downwash, with turbulence."""

    def __init__(self, start: Array, strength: float, seed: int) -> None:
        super().__init__(NAMES, CRAZYFLIE_2_0, start, WakeLaw.MEASURED)
        self._strength, self._rng, self._now = strength, np.random.default_rng(seed), np.zeros(2)

    def step(self, commands: Array, drive: Array) -> None:
        """Advance with the rest of the downwash and the turbulence as moving air."""
        fresh = TURBULENCE * np.sqrt(1.0 - MEMORY**2) * self._rng.standard_normal(2)
        self._now = MEMORY * self._now + fresh
        air = drive.copy()
        air[:, 2] += self._now + (self._strength - 1.0) * self.downwash()[:, 2]
        super().step(commands, air)


def air(strength: float, first: int = 0) -> MakeDraw:
    """Return what makes swarms in an air of this strength, their seeds counted from `first`."""
    still = DisturbanceParams()

    def make(seed: int, start: Array) -> Draw:
        return Draw(Turbulent(start, strength, first + seed), Disturbance(still, 2, DT, seed))

    return make


def passes(seconds: float, period: float = 8.0) -> TrackedFlight:
    """Return a plan: cf1 swings along x below cf2, which stays 0.4 m above; both bob."""
    t = DT * np.arange(round(seconds / DT))
    bob, still = 0.05 * np.sin(2.1 * t), np.zeros_like(t)
    lower = np.stack([0.4 * np.cos(2.0 * np.pi * t / period), still, 0.6 + bob], axis=-1)
    upper = np.stack([0.1 * np.sin(t), 0.1 * np.cos(0.7 * t), 1.0 + bob], axis=-1)
    ref = np.stack([lower, upper], axis=1)
    vel = np.gradient(ref, DT, axis=0)
    rng = np.random.default_rng(1)
    none = np.zeros((len(t), 2), dtype=bool)
    return TrackedFlight(
        name="passes",
        names=NAMES,
        dt=DT,
        pos=ref + 2e-4 * rng.standard_normal(ref.shape),
        vel=vel + 1e-3 * rng.standard_normal(ref.shape),
        quat=identity_quat((len(t), 2)),
        ref_pos=ref,
        ref_vel=vel,
        ref_acc=np.gradient(vel, DT, axis=0),
        acc=np.full(ref.shape, np.nan),
        thrust=np.zeros((len(t), 2)),
        compensated=np.zeros((len(t), 2)),
        usable=~none,
        exposed=none,
        free=none,
        scored=np.ones(2, dtype=bool),
        sure=~none,
        stepped=none,
    )


def recorded(plan: TrackedFlight, make: MakeDraw) -> TrackedFlight:
    """Return a plan as flown under LAW by the first draw of an air."""
    flown = redraw_flight(ReadFlight(plan, LAW), CRAZYFLIE_2_0.mass, make, [0])
    pos, vel, quat = flown.pos[0], flown.vel[0], flown.quat[0]
    everywhere = np.ones(pos.shape[:2], dtype=bool)
    motion = Motion(plan.t, pos, vel, rotate(quat, UP))
    pushes = PushRecord("passes", NAMES, motion, np.zeros(pos.shape[:2]), everywhere, ~everywhere)
    rows = [scored_rows(pushes, i) for i in range(2)]
    exposed, free = (np.stack([getattr(row, what) for row in rows], axis=1) for what in ("exposed", "free"))
    thrust = flown.thrust[0]
    return replace(plan, pos=pos, vel=vel, quat=quat, thrust=thrust, exposed=exposed, free=free)


@pytest.fixture(scope="module")
def flight() -> TrackedFlight:
    """Return a flight in the air of strength 1."""
    return recorded(passes(24.0), air(1.0, first=100))


@pytest.fixture(scope="module")
def own(flight: TrackedFlight) -> ValidatedFlight:
    """Return the flight flown again in its own air."""
    return validate_flight(flight, CRAZYFLIE_2_0, air(1.0))


def test_the_law_is_read_from_the_commands(flight: TrackedFlight):
    law = read_law(flight, CRAZYFLIE_2_0).law
    np.testing.assert_allclose(law.k_p, LAW.k_p, rtol=0.02)
    np.testing.assert_allclose(law.k_d, LAW.k_d, rtol=0.02)
    assert law.k_i[2] == pytest.approx(0.6, rel=0.1)
    np.testing.assert_allclose(law.offset, 0.0, atol=0.05)
    assert law.attitude.frequency == pytest.approx(60.0, abs=10.0)


def test_the_offset_of_a_vehicle_balances_its_clear_air(flight: TrackedFlight):
    heavy = replace(flight, thrust=flight.thrust + 0.01, vel=flight.vel)
    assert read_law(heavy, CRAZYFLIE_2_0).law.k_p[2] == pytest.approx(10.0, rel=0.02)
    biased = replace(flight, ref_acc=flight.ref_acc - np.array([0.0, 0.0, 0.2]))
    np.testing.assert_allclose(read_law(biased, CRAZYFLIE_2_0).law.offset[:, 2], 0.2, atol=0.05)


def test_a_limited_velocity_setpoint_gives_its_acceleration_by_the_command(flight: TrackedFlight):
    limit = 0.6 * np.abs(flight.ref_vel[:, 0, 2]).max()
    clipped = np.clip(flight.ref_vel, -limit, limit)
    shown = replace(flight, ref_vel=clipped, ref_acc=np.gradient(clipped, DT, axis=0))
    feedback_too = LAW.k_d * (flight.ref_vel - clipped)  # what the limit hides from the law
    whole = read_law(shown, CRAZYFLIE_2_0).flight.ref_acc
    rows = np.abs(clipped[:, 0, 2]) >= limit
    miss = (whole - flight.ref_acc - feedback_too)[rows, 0, 2]
    assert rows.mean() > 0.3
    assert np.sqrt((miss**2).mean()) < 0.05


def test_a_flight_validates_in_its_own_air(own: ValidatedFlight):
    found = pooled_comparison([own])
    assert found.n > 200
    assert found.z_rms_ratio == pytest.approx(1.0, abs=0.15)
    assert found.correlation == pytest.approx(1.0, abs=0.1)
    assert found.coverage95 == pytest.approx(0.95, abs=0.05)
    assert comparison(own.clear).coverage95 == pytest.approx(0.95, abs=0.05)


def test_a_flight_does_not_validate_in_an_air_twice_as_strong(flight: TrackedFlight):
    found = pooled_comparison([validate_flight(flight, CRAZYFLIE_2_0, air(2.0))])
    assert found.z_rms_ratio is not None
    assert found.coverage95 is not None
    assert found.z_rms_ratio > RMS_RATIO[1]
    assert found.coverage95 < COVERAGE[0]
    assert "times the recorded" in validation_sentence(found)


def test_a_flight_without_a_wake_has_clear_air_only(own: ValidatedFlight):
    alone = replace(own, under=tuple(replace(part, n=0) for part in own.under))
    text = as_json([alone], in_fit=("room/" + alone.flight.name,))
    assert text["flights"][alone.flight.name]["in_fit"]
    assert not as_json([alone], in_fit=("another",))["flights"][alone.flight.name]["in_fit"]
    assert text["pooled"] == {
        "z_rms_ratio": None,
        "correlation": None,
        "spectrum_db": None,
        "coverage95": None,
        "worst_ratio": None,
        "n": 0,
        "z_rms_recorded_m": None,
    }
    assert "not compared" in str(text["verdict"])


def test_a_flight_without_commands_is_refused(flight: TrackedFlight):
    with pytest.raises(ValueError, match=r"0\.0 s with thrust commands, and 0 samples"):
        read_law(replace(flight, thrust=np.full_like(flight.thrust, np.nan)), CRAZYFLIE_2_0)


@pytest.mark.parametrize(
    ("k_d", "k_i", "axis"),
    [((-0.22, -0.22, 5.0), 0.6, "x and y"), ((10.0, 10.0, 0.0), 0.6, "z"), ((10.0, 10.0, 5.0), 51.0, "z")],
)
def test_gains_that_stabilise_no_vehicle_are_not_flown_again(
    k_d: tuple[float, ...], k_i: float, axis: str
) -> None:
    check_stable("sound", LAW, CRAZYFLIE_2_0.thrust_lag, 60.0)
    with pytest.raises(ValueError, match=f"flight shaky cannot .* gains of {axis} .* are unstable"):
        check_stable(
            "shaky", replace(LAW, k_d=np.array(k_d), k_i=np.full(3, k_i)), CRAZYFLIE_2_0.thrust_lag, 60.0
        )


def growth(law: RecordedLaw) -> float:
    """Return how much larger horizontal errors are in the last third of 24 s without downwash than before."""
    plan = passes(24.0)
    flown = redraw_flight(ReadFlight(plan, law), CRAZYFLIE_2_0.mass, air(0.0), [0])
    error = np.abs(flown.pos[0] - plan.ref_pos)[..., :2]
    return float(error[-800:].max() / error[:800].max())


def test_a_law_by_which_vehicles_run_away_is_not_flown_again() -> None:
    """Gains read from bags/table2_1, with its attitude loop of 15 rad/s, and with a quick one."""
    quick = replace(LAW, k_p=np.array([18.7, 18.7, 10.0]), k_d=np.array([8.55, 8.55, 5.0]))
    slow = replace(quick, attitude=replace(LOOP, frequency=15.0))
    assert growth(quick) < 1.0
    check_stable("quick", quick, CRAZYFLIE_2_0.thrust_lag, 24.0)
    assert growth(slow) > np.exp(16.0 / 13.0)  # the ticks of the controller delay it further
    with pytest.raises(ValueError, match=r"gains of x and y .* errors grow e-fold in 13 s of 24 s"):
        check_stable("slow", slow, CRAZYFLIE_2_0.thrust_lag, 24.0)


def test_a_flight_whose_law_cannot_be_read_is_left_out_and_the_others_are_compared(
    flight: TrackedFlight, capsys: pytest.CaptureFixture[str]
) -> None:
    mute = replace(flight, name="mute", thrust=np.full_like(flight.thrust, np.nan))
    done = _all_flown([mute, flight], RoomAir(), CRAZYFLIE_2_0, 3)
    assert [one.flight.name for one in done] == [flight.name]
    assert "validate: left out: flight mute cannot be flown again" in capsys.readouterr().err


def test_a_flight_too_slow_for_its_noise_is_refused(flight: TrackedFlight) -> None:
    slow = replace(flight, dt=0.04)
    with pytest.raises(ValueError, match=r"flight passes .* above 15 Hz, and its 25 Hz show none; 30 Hz is"):
        estimate_noise(slow, 0)
    felt = replace(slow, acc=np.random.default_rng(0).standard_normal(flight.pos.shape))
    assert np.isfinite(estimate_noise(felt, 0)).all()  # read above 3.2 Hz
    for dt in (1.0 / 32.0, 1.0 / 30.0 + 1e-12):  # of stamps that rounding makes differ
        assert np.isfinite(estimate_noise(replace(flight, dt=dt), 0)).all()


def test_a_draw_has_the_recorded_headroom_of_each_vehicle_and_no_second_drag(flight: TrackedFlight):
    own = VehicleTerm(0.0, 0.0, 0.07, 1.9, 0.0, 0.0, headroom_std=0.2)
    room = RoomAir(vehicle=own, rotor_drag=RotorDragTerm(0.4))
    recorded_too = replace(flight, headroom=np.array([[1.5, 1.4, 1.6, 1.5], [1.8, 1.9, 1.7, 1.8]]))
    apart = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, 0.0]])
    swarm = draws_in(room, recorded_too, CRAZYFLIE_2_0)(3, apart).swarm
    headroom = 4.0 * swarm.air.room.rotor_max / CRAZYFLIE_2_0.hover_thrust
    np.testing.assert_allclose(headroom, recorded_too.headroom)
    swarm.state[:, VEL] = [1.0, 0.0, 0.0]
    assert not swarm.downwash().any()  # redrawn_flight adds the drag that the flight shows


def test_the_drag_of_the_rotors_is_read_from_the_accelerometer(flight: TrackedFlight):
    tilt = 0.2 * np.sin(flight.t)[:, None]
    still = np.zeros_like(tilt)
    quat = np.stack([still, np.sin(tilt / 2.0), still, np.cos(tilt / 2.0)], axis=-1) * np.ones(
        (1, 2, 1)
    )  # pitch
    thrust = 9.81 * rotate(quat, UP) - np.array([0.0, 0.0, 9.81])
    bias = 0.1 * rotate(quat, np.array([1.0, 0.0, 0.0]))
    moving = replace(
        flight,
        quat=quat,
        free=np.ones_like(flight.free),
        acc=thrust + bias + drag_acceleration(0.4, flight.vel, quat),
    )
    assert read_drag(moving) == pytest.approx(0.4, rel=1e-6)
    assert read_drag(flight) == 0.0  # it has no accelerometer


def test_the_replay_shows_the_recording_beside_its_first_draw(own: ValidatedFlight):
    recorded, simulated = replayed_runs(own)
    np.testing.assert_array_equal(recorded.pos, own.flight.pos)
    height_error = simulated.pos[..., 2] - simulated.ref_pos[..., 2]
    np.testing.assert_array_equal(height_error, own.drawn[0])
    assert longest_under_wake([own]) is own


def test_the_figure_of_a_flight_has_no_empty_panel(own: ValidatedFlight):
    panels = error_figure(own).axes
    assert len(panels) == 1  # cf2 is never under another vehicle
    assert [len(line.get_ydata()) for line in panels[0].lines] == [len(own.flight.t)] * 2
