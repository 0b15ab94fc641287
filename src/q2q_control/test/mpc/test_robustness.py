"""With a wrong model, a missing or stale neighbour, or saturated, awareness does no harm."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.explicit_mpc.distillation import DistillationParams, distil
from q2q_control.explicit_mpc.explicit_law import ExplicitLaw
from q2q_control.explicit_mpc.explicit_solver import explicit_solver
from q2q_control.explicit_mpc.teacher import Teacher
from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, SwarmImu, SwarmSetpoint, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

DT = 0.01
"""[s]"""
NAMES = ("cf1", "cf2")
TICKS = 1200
WAKE = Jet(
    strength=1.2,
    reference_gap=0.4,
    decay="exponential",
    width=0.06,
    upper_ratio=0.02,
    travel_speed=7.5,
    range=1.2,
)
"""The true downwash: as late and narrow as measured, half as strong, so that 12 N carry it."""
TIGHT = 7.2
"""A bound on U1 [N] that carries 1.27 m/s^2 of downwash barely, with some left [N]."""

Spoil = Callable[[int, SwarmState], SwarmState]
Controller = Pid | ObservedPid | Mpc


@dataclass(frozen=True)
class Case:
    """Model of the controller, and signals withheld from it."""

    model: Jet = WAKE
    spoil: Spoil = lambda _, state: state
    thrust_max: float = 12.0


def late(seconds: float) -> Jet:
    """Return the wake with another delay at a gap of 0.5 m."""
    delay = max(0.5 / 7.5 + seconds, 1e-3)
    return replace(WAKE, travel_speed=0.5 / delay)


def blind(_: int, state: SwarmState) -> SwarmState:
    """Hide the upper vehicle."""
    return of_vehicles(state, np.array([0]))


def stuck(k: int, state: SwarmState) -> SwarmState:
    """Lose the upper vehicle from tick 380 on, when it comes above the lower one: held where it was."""
    if k < 380:
        return state
    pos, vel = state.pos.copy(), state.vel.copy()
    pos[1], vel[1] = [0.0, 0.5 - 0.125 * 380 * DT, 1.5], 0.0
    status = np.array([0, TrackStatus.LOST if k > 410 else TrackStatus.COASTING], np.uint8)
    return replace(state, pos=pos, vel=vel, status=status)


KINDS = (
    "pid", "pid with integral", "pid with observer", "pid with correction", "mpc", "mpc without observer",
    "mpc with correction", "explicit",
)  # fmt: skip
SILENT = "mpc with correction, silent"
"""Without accelerometers."""
UNCORRECTED = {"pid with correction": "pid with observer", "mpc with correction": "mpc", SILENT: "mpc"}
"""Controllers that ignore the downwash and those with correction, which finds it without a model."""
CREDULOUS = ("mpc without observer", "saturated, gain +50 %")
"""Without an observer nothing reveals a wrong model, and at a bound the MPC acts on it ahead."""
CASES = {
    "gain +50 %": Case(replace(WAKE, strength=1.5 * WAKE.strength)),
    "gain -50 %": Case(replace(WAKE, strength=0.5 * WAKE.strength)),
    "delay +50 ms": Case(late(0.05)),
    "delay -50 ms": Case(late(-0.05)),
    "missing neighbour": Case(spoil=blind),
    "stale neighbour": Case(spoil=stuck),
    "saturated": Case(thrust_max=TIGHT),
    "saturated, gain +50 %": Case(replace(WAKE, strength=1.5 * WAKE.strength), thrust_max=TIGHT),
}


FLOWN = [
    *((kind, name) for kind in KINDS for name in CASES),
    (SILENT, "gain +50 %"),
    (SILENT, "saturated"),
]


def plan() -> SampledPreview:
    """Return cf1 hovering at 1 m, cf2 flying over it 0.5 m higher at 0.125 m/s."""
    t = np.arange(0.0, TICKS * DT + 4.0, DT)
    samples = np.zeros((2, t.size, 9))
    samples[0, :, 2] = 1.0
    samples[1, :, 1], samples[1, :, 2], samples[1, :, 4] = 0.5 - 0.125 * t, 1.5, -0.125
    return SampledPreview(NAMES, 0.0, DT, samples)


def built(kind: str, case: Case, preview: SampledPreview) -> Controller:
    gains = PidParams(k_p_z=10.0, k_d_z=5.0, thrust_limited=True, thrust_max=case.thrust_max)
    if kind == "pid":
        return Pid(gains, TEXTBOOK_065)
    if kind == "pid with integral":
        return Pid(replace(gains, k_i_z=3.0), TEXTBOOK_065)
    if kind == "pid with observer":
        return ObservedPid(gains, TrackerParams(latency=0.0), TEXTBOOK_065)
    if kind == "pid with correction":
        return ObservedPid(gains, TrackerParams(latency=0.0), TEXTBOOK_065, residual_process=REAL_FLIGHTS)
    params = MpcParams(
        latency=0.0, thrust_limited=True, thrust_max=case.thrust_max, observe=kind != "mpc without observer"
    )
    setup = MpcSetup(preview=preview, residual_process=REAL_FLIGHTS if "correction" in kind else None)
    if kind == "explicit":
        setup = replace(setup, solver=explicit_solver(law(case.model, case.thrust_max)))
    return Mpc(params, TEXTBOOK_065, case.model, setup)


@cache
def law(model: Jet, thrust_max: float) -> ExplicitLaw:
    """Return the law distilled with the believed model and bound."""
    params = MpcParams(latency=0.0, thrust_limited=True, thrust_max=thrust_max)
    short = DistillationParams(situations=2000, encounters=40, length=60, layers=(16, 10), iterations=200)
    return distil(Teacher(params, TEXTBOOK_065, model, thrust_max), short, np.random.default_rng(0))


def height_errors(kind: str, case: Case, *, aware: bool) -> Array:
    """Return the lower vehicle's height errors [m], (TICKS,)."""
    preview = plan()
    controller, truth, belief = (
        built(kind, case, preview),
        InteractionPredictor(WAKE),
        InteractionPredictor(case.model),
    )
    pos, vel = preview.samples[:, 0, :3].copy(), preview.samples[:, 0, 3:6].copy()
    errors = []
    for k in range(TICKS):
        real = whole_state(k * DT, pos, vel)
        seen = case.spoil(k, real)
        downwash = belief.update(seen) if aware else None
        thrust = controller.update(seen, setpoint(k * DT, preview.samples[:, k]), downwash).thrust
        acc = truth.update(real).acc[:, 2] + thrust / TEXTBOOK_065.mass - GRAVITY
        if not isinstance(controller, Pid) and kind != SILENT:
            force = np.column_stack([np.zeros((2, 2)), acc + GRAVITY])
            controller.sense(SwarmImu(k * DT, NAMES, force, np.zeros((2, 3))))
        acc[1] = 0.0  # the upper one keeps to its path
        pos[:, 2], vel[:, 2] = pos[:, 2] + DT * vel[:, 2] + 0.5 * DT**2 * acc, vel[:, 2] + DT * acc
        pos[1], vel[1] = preview.samples[1, k + 1, :3], preview.samples[1, k + 1, 3:6]
        pos[0, :2] = 0.0
        errors.append(pos[0, 2] - 1.0)
    return np.array(errors)


def whole_state(t: float, pos: Array, vel: Array) -> SwarmState:
    return resting_state(t, NAMES, pos.copy(), vel=vel.copy())


def setpoint(t: float, ref: Array) -> SwarmSetpoint:
    return resting_setpoint(t, NAMES, ref[:, :3], vel=ref[:, 3:6], acc=ref[:, 6:])


@dataclass(frozen=True)
class Flown:
    """Flight of an aware controller in a case."""

    kind: str
    name: str
    errors: Array


@pytest.fixture(scope="module", params=FLOWN, ids=" in ".join)
def flown(request: pytest.FixtureRequest) -> Flown:
    """Return the aware flight, which all tests of it share."""
    kind, name = request.param
    return Flown(kind, name, height_errors(kind, CASES[name], aware=True))


@cache
def ignoring_errors(kind: str, case: Case) -> Array:
    """Return the height errors of the controller that is given no downwash."""
    return height_errors(kind, case, aware=False)


def ignoring(kind: str, name: str) -> Array:
    """Return the flight without awareness, which only a distilled law lets depend on the model."""
    case, kind = CASES[name], UNCORRECTED.get(kind, kind)
    return ignoring_errors(kind, case if kind == "explicit" else replace(case, model=WAKE))


def test_it_is_never_worse_than_ignoring_by_more_than_five_percent(flown: Flown):
    if (flown.kind, flown.name) == CREDULOUS:
        pytest.skip("the known exception: another test holds how bad it is")
    aware, blank = flown.errors, ignoring(flown.kind, flown.name)
    assert np.sqrt((aware**2).mean()) <= 1.05 * np.sqrt((blank**2).mean())
    assert np.abs(aware).max() <= 1.05 * np.abs(blank).max()


def test_no_wind_up_and_no_limit_cycle_are_left_when_the_downwash_has_gone(flown: Flown):
    after = flown.errors[1000:]  # 1.6 s after the downwash's end, four widths away
    # the integral's slow pole is at K_i / K_p = 0.3 rad/s: it still unloads, without turning round
    left = 0.25 if flown.kind == "pid with integral" else 0.05
    assert np.abs(after).max() < left * np.abs(flown.errors).max() + 1e-6
    # with correction the estimated bias, off by a share of the push, returns at 0.3 rad/s after a second
    turned = 100 if "correction" in flown.kind else 0
    assert abs(after[-1]) <= abs(after[turned]) + 1e-6
    crossings = np.count_nonzero(np.diff(np.sign(after[np.abs(after) > 1e-5])))
    assert crossings <= 2


def test_what_looks_ahead_and_does_not_look_back_climbs_for_a_downwash_that_never_comes():
    kind, name = CREDULOUS
    aware = height_errors(kind, CASES[name], aware=True)
    # 1.65 m/s^2 are believed, 1.27 can be carried, 1.09 come: it climbs ahead for 0.4 m/s^2 too much
    assert 1.05 < np.sqrt((aware**2).mean()) / np.sqrt((ignoring(kind, name) ** 2).mean()) < 1.6


@pytest.mark.parametrize(
    "kind", ["pid", "pid with observer", "mpc", "mpc with correction", "mpc without observer", "explicit"]
)
def test_the_right_model_is_much_better_than_ignoring(kind: str):
    aware = height_errors(kind, Case(), aware=True)
    assert np.sqrt((aware**2).mean()) < 0.15 * np.sqrt((ignoring_errors(kind, Case()) ** 2).mean())
