"""What the receding-horizon controller does where it cannot solve, has no downwash, or may not."""

from dataclasses import replace

import numpy as np
import pytest
from mpc_bench import DT, IDEAL, PAIR, Air, controller, first_tick, hover, pass_over, signals

from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.interaction_model import PairMotion
from q2q_model.downwash.jet import PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import TEXTBOOK_065


def test_a_solve_that_comes_too_late_is_replaced_by_the_shifted_solution_then_by_a_pd_law():
    preview, left = pass_over(), [10**9]

    def in_time() -> bool:
        left[0] -= 1
        return left[0] >= 0

    mpc = Mpc(IDEAL, TEXTBOOK_065, PAPER_LAW, MpcSetup(in_time=in_time, preview=preview))
    lines = []

    def spoil(k: int, state: SwarmState) -> SwarmState:
        lines.append((mpc.report.sources.shifted, mpc.report.sources.pd))
        left[0] = 0 if k >= 300 else 10**9
        return state

    errors, thrust = Air(preview).fly(mpc, 420, spoil)
    assert lines[300] == (0, 0)
    assert lines[305] == (2, 0)
    assert lines[340] == (0, 2)
    assert np.isfinite(thrust).all()
    assert np.abs(errors).max() < 0.05


def test_a_model_that_returns_nan_is_survived_and_said():
    class Broken(Jet):
        def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
            return np.full(rel_pos.shape, np.nan)

    preview = pass_over()
    mpc = controller(IDEAL, preview, Broken())
    _, thrust = Air(preview).fly(mpc, 20)
    assert np.isfinite(thrust).all()
    assert mpc.report.sources.solved == 2
    assert mpc.report.pairs == 0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_no_number_holds_then_levels_and_the_other_flies_on(bad: float):
    preview = hover(PAIR)
    mpc = controller(IDEAL, preview)

    def spoil(k: int, state: SwarmState) -> SwarmState:
        pos = state.pos.copy()
        pos[0] = bad if k >= 20 else pos[0]
        return replace(state, pos=pos)

    errors, thrust = Air(preview).fly(mpc, 60, spoil)
    assert np.isfinite(thrust).all()
    assert np.abs(errors[:, 1]).max() < 1e-9
    state, setpoint, downwash = first_tick(preview, 60)
    lost = replace(state, status=np.array([TrackStatus.LOST, 0], np.uint8))
    assert mpc.update(lost, setpoint, downwash).status[0] == CommandStatus.LEVEL


@pytest.mark.parametrize("missing", ["a number", "the setpoint"])
def test_a_vehicle_without_setpoint_pushes_from_where_it_is_seen(missing: str):
    """One vehicle hovers above another, and its setpoint is missing from one tick."""
    preview = SampledPreview(PAIR, 0.0, DT, np.zeros((2, 100, 9)))
    preview.samples[:, :, 2] = np.array([[1.0], [1.4]])
    mpc = Mpc(MpcParams(latency=0.0), TEXTBOOK_065, PAPER_LAW, MpcSetup(vehicles=PAIR, preview=preview))
    for k in range(30):
        aware = mpc.update(*first_tick(preview, k))
    state, setpoint, downwash = first_tick(preview, 30)
    if missing == "a number":
        setpoint = replace(setpoint, pos=np.array([[0.0, 0.0, 1.0], [0.0, 0.0, np.nan]]))
    else:
        columns = ("pos", "vel", "acc", "yaw", "yaw_rate", "status")
        setpoint = replace(setpoint, names=PAIR[:1], **{one: getattr(setpoint, one)[:1] for one in columns})
    command = mpc.update(state, setpoint, downwash)
    assert command.status.tolist() == [CommandStatus.OK, CommandStatus.HOLD]
    assert aware.thrust[0] > 1.04 * TEXTBOOK_065.hover_thrust  # against the downwash
    assert command.thrust[0] == pytest.approx(aware.thrust[0], rel=1e-3)


def test_without_any_setpoint_all_hold():
    preview = hover(PAIR)
    mpc = Mpc(IDEAL, TEXTBOOK_065, PAPER_LAW, MpcSetup(vehicles=PAIR, preview=preview))
    state, setpoint, downwash = first_tick(preview)
    mpc.update(state, setpoint, downwash)
    columns = ("pos", "vel", "acc", "yaw", "yaw_rate", "status")
    nobody = replace(setpoint, t=DT, names=(), **{one: getattr(setpoint, one)[:0] for one in columns})
    command = mpc.update(replace(state, t=DT), nobody, downwash)
    assert command.status.tolist() == [CommandStatus.HOLD] * 2


def test_vehicles_lost_in_a_gap_count_as_on_their_references_and_are_found_there_by_the_first_solve():
    """Both are lost for 6 ticks after 0.4 s without one; the one that finds them is solved as any other."""
    preview = pass_over(speed=0.2, start=0.3, gap=1.0)
    known, unsure = controller(MpcParams(), preview), controller(MpcParams(), preview)
    for k in [*range(10), *range(50, 57)]:
        state, setpoint, downwash = first_tick(preview, k)
        lost = replace(state, status=np.full(2, TrackStatus.LOST if 50 <= k < 56 else 0, np.uint8))
        whole, some = known.update(state, setpoint, downwash), unsure.update(lost, setpoint, downwash)
        assert unsure.report.iterations == 1
    # what was commanded meanwhile, and with it the thrust, differs: hover, and the compensation
    np.testing.assert_allclose(some.thrust, whole.thrust, atol=0.02 * TEXTBOOK_065.hover_thrust)


def test_rotors_too_weak_to_hover_saturate_and_sink_without_winding_up():
    preview, weak = hover(), replace(TEXTBOOK_065, thrust_max=6.0)
    mpc = Mpc(IDEAL, weak, PAPER_LAW, MpcSetup(preview=preview))
    _, thrust = Air(preview).fly(mpc, 100)
    assert np.all(thrust == 6.0)
    state, setpoint, downwash = first_tick(preview, 100)
    above = replace(state, pos=state.pos + np.array([0.0, 0.0, 1.0]))
    assert mpc.update(above, setpoint, downwash).thrust[0] < 6.0


def test_a_reference_that_no_vehicle_can_follow_is_approached_within_the_limits():
    preview = hover()
    jump = replace(preview, samples=preview.samples.copy())
    jump.samples[:, 100:, 2] += 3.0
    mpc = controller(IDEAL, jump)
    errors, thrust = Air(jump).fly(mpc, 1100)
    assert thrust.max() <= 6.6
    assert thrust.min() >= 0.0
    assert abs(errors[-1, 0]) < 0.03  # 3 m at 0.34 m/s^2 take 6 s, and the end is soft
    assert errors[100:, 0].max() < 0.15  # a horizon of 2 s brakes in time


def test_a_horizon_of_zero_is_refused():
    with pytest.raises(ValueError, match=r"horizon = 0.0; must be in \[0.2, 10.0\] s"):
        MpcParams(horizon=0.0)


def test_a_repeated_stamp_gets_the_same_answer():
    preview = pass_over()
    mpc = controller(IDEAL, preview)
    at = first_tick(preview)
    assert mpc.update(*at) is mpc.update(*at)


def test_ignoring_means_no_model():
    preview = pass_over()
    mpc = controller(IDEAL, preview)
    state, setpoint, _ = first_tick(preview, 300)
    mpc.update(state, setpoint, None)
    assert mpc.report.pairs == 0


def test_a_vehicle_without_neighbours_flies_like_one_without_model():
    preview = hover()
    at = signals(0.0, ("cf1",), preview.samples[:, 0, :3] + 0.1, np.zeros((1, 3)), preview.samples[:, 0])
    with_model = controller(IDEAL, preview).update(*at)
    without = controller(IDEAL, preview, NoInteraction()).update(*at)
    assert np.array_equal(with_model.thrust, without.thrust)
