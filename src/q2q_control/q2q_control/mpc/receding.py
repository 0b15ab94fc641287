"""Control with a receding horizon that holds the downwash: (26), solved anew every tick.

Every tick: where will the vehicles be when a command given now acts (latency, lags, disturbance: `present`);
where do the references go (`preview`); which downwash lie ahead on the last predicted paths
(`downwash_horizon`); the inputs that keep the vehicles nearest to their references within thrust, tilt and
their rates (`planner`); the first of them as thrust, roll and pitch.

    minimise sum_k sum_j (r_j(t_k) - r_j,ref(t_k))^2 + (effort)      of (26), for all vehicles that interact
    v' = a + eta(r, r(t - tau)) + d,   a' = (u - a) / T              downwash linear along the last prediction
    0 <= U1 <= U_max, |tilt| <= tilt_max, both with bounded rates

One linearisation and one solve a tick (real-time iteration; Diehl, Bock, Schloeder, SIAM J. Control Optim.
43, 2005): the next tick goes on from this one's paths. The downwash depends on where the others go, so the
upper vehicle may rise to spare the lower one: that is what joint control buys (Table 7).

| a vehicle's horizon | is flown by | counted as |
|---|---|---|
| solved, or its bounds kept though not optimal | its first input | solved, cut_off |
| not solved in time or not finite, up to shift_time after the last solve | its last plan, shifted | shifted |
| the same, later | PID with the loop's bandwidths | pid |
| without usable state or setpoint | q2q_control.failsafe.last_commands: HOLD, then LEVEL | |
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from q2q_control.failsafe.last_commands import HoldThenLevel, LastCommands
from q2q_control.inputs.alignment import ETA, QUAT, Aligned, align
from q2q_control.inputs.preview import ReferencePreview, shifted_preview
from q2q_control.mpc.chain import ChainWeights, chain
from q2q_control.mpc.horizon_solver import HorizonSolver, Solver, SolveRules
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_horizon import (
    DownwashHorizon,
    SlopeRule,
    no_downwash,
    predict_downwash,
)
from q2q_control.mpc.prediction.plan_memory import Plan, PlanMemory
from q2q_control.mpc.prediction.predictions import Predictions
from q2q_control.mpc.prediction.present import Present, PresentEstimator, axis_lags
from q2q_control.mpc.prediction.surroundings import Surroundings
from q2q_control.mpc.problem.horizon import CUT_OFF, INTERRUPTED, Horizon, HorizonSolution
from q2q_control.mpc.problem.input_bounds import bounds_of
from q2q_control.pid.pid_kernel import command_rows, packed_numbers
from q2q_control.pid.thrust_vector import ThrustLimits
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.values import (
    Array,
    Interference,
    InterferenceStatus,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    index_of,
)
from q2q_model.vehicle.constants import GRAVITY, Vehicle

TICK = 0.01
"""How long a command acts before the next one comes [s]: the house's tick."""


@dataclass(frozen=True, slots=True)
class MpcReport:
    """Say how the last tick was answered: vehicles by the source of their command."""

    solved: int = 0
    cut_off: int = 0
    shifted: int = 0
    pid: int = 0
    iterations: int = 0
    """Most recursions that one problem took."""
    pairs: int = 0
    """Pairs whose downwash matter on the horizon."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """Hold what lies ahead of n vehicles."""

    reference: Array
    """Position [m], velocity [m/s], acceleration [m/s^2], world, (n, N + 1, 9)."""
    plan: Plan
    """The last one, shifted to now."""
    downwash: DownwashHorizon
    everyone: Array
    """Predicted positions [m], world, of the n and of others, (n or more, N + 1, 3)."""


class Mpc:
    """Remember plans, thrust, disturbances and where the vehicles were."""

    def __init__(
        self,
        params: MpcParams,
        vehicle: Vehicle,
        model: InteractionModel,
        vehicles: Names = (),
        in_time: Callable[[], bool] = lambda: True,
    ) -> None:
        """Control vehicles like `vehicle`: those named, or all of the setpoint.

        Args:
            params: horizon, weights, limits.
            vehicle: constants of every vehicle.
            model: the downwash as the controller knows it.
            vehicles: who is controlled; empty is all of the setpoint.
            in_time: asked before each problem of a tick; False ends the tick's solving.
        """
        self._vehicle, self._vehicles, self._in_time = vehicle, vehicles, in_time
        self.model = model
        self.preview: ReferencePreview | None = None
        """Where the references will go; None lets each setpoint go on by itself."""
        self._surroundings = Surroundings()
        self.configure(params)

    def configure(self, params: MpcParams) -> None:
        """Use other parameters; plans and estimates start anew, and the solver is the optimum's again."""
        self._params = params
        self._surroundings.loading = params.loading
        xy, z = ChainWeights(params.bandwidth_xy, params.jerk), ChainWeights(params.bandwidth_z, params.jerk)
        lags = axis_lags(params, self._vehicle)
        side, up = chain(lags[0], params.step, xy), chain(lags[2], params.step, z)
        coupled = (0, 1, 2) if params.mode == "full" else (2,)
        models = (side, side, up)
        rules = SolveRules(params.joint, params.terminal, params.iterations)
        self.solver: Solver = HorizonSolver(models, coupled, params.steps, rules)
        self._slopes = SlopeRule(coupled, params.slope_max)
        allowed = params.thrust_max if params.thrust_limited else self._vehicle.rpyt_thrust_max
        self._limits = ThrustLimits(
            self._vehicle.mass, min(allowed, self._vehicle.rpyt_thrust_max), params.tilt_max, exact=True
        )
        self._numbers = packed_numbers(np.zeros((4, 3)), self._limits, (params.k_yaw, params.yaw_rate_max))
        self._nearly_full = self._limits.thrust_max * (1.0 - 1e-9)
        share = [1.0 - float(model.transition[2, 2]) for model in models]
        rates = np.array([GRAVITY * params.tilt_rate_max] * 2 + [params.thrust_rate_max])
        self._step_max = rates * params.step / np.array(share)
        self._ahead = params.step * np.arange(params.steps + 1)
        hover = min(self._vehicle.hover_thrust, self._limits.thrust_max)
        self._rows = LastCommands(HoldThenLevel(params.hold_time, hover))
        self.reset()

    def reset(self) -> None:
        """Forget all memory."""
        self._plans = PlanMemory(self._params.steps, self._params.step)
        self._present = PresentEstimator(self._params, self._vehicle)
        self._surroundings.reset()
        self._rows.reset()
        self._last: SwarmCommand | None = None
        self.report = MpcReport()
        self.told: Predictions | None = None

    def hear(self, said: Predictions) -> None:
        """Take what neighbours of other controllers say of their paths; it counts until they say more."""
        self._surroundings.heard = said

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the downwash."""
        last, names = self._last, self._vehicles or setpoint.names
        if last is not None and last.t == setpoint.t and last.names == names:
            return last
        if last is not None and setpoint.t < last.t:
            self.reset()
        tick = align(state, setpoint, interference, names)
        outlook = self._outlook(tick, (state, setpoint), aware=interference is not None)
        if interference is not None and (self._params.loading > 0.0 or interference.status.any()):
            self._correct_downwash(tick, interference, outlook.downwash)
        present = self._present.update(tick, state)
        horizon = self._horizon(tick, present, outlook)
        acc = self._answered(tick, horizon, outlook)
        self._last = self._command(tick, acc)
        self._present.sent(self._last, tick)
        return self._last

    def _outlook(self, tick: Aligned, signals: tuple[SwarmState, SwarmSetpoint], *, aware: bool) -> Outlook:
        """Return what lies ahead of the tick's vehicles."""
        state, setpoint = signals
        times = self._stages(tick.t + self._params.latency)
        reference = self._reference(tick, setpoint, times)
        plan = self._plans.shifted(tick.names, float(times[0]))
        path = reference[..., :3] + plan.offset
        span = self.model.max_delay if aware else 0.0
        tracks = self._surroundings.tracks(tick, state, (times, path, plan.inputs), span)
        downwash = predict_downwash(self.model, tracks, self._slopes) if aware else no_downwash(tracks)
        everyone = np.ascontiguousarray(tracks.pos[tracks.first :].transpose(1, 0, 2))
        return Outlook(reference, plan, downwash, everyone)

    def _correct_downwash(self, tick: Aligned, interference: Interference, downwash: DownwashHorizon) -> None:
        """Replace the predictor's present downwash where it is not valid or ignores the sources' thrust.

        It cannot know who is lost to us.
        """
        status = np.append(interference.status, InterferenceStatus.NO_MODEL)
        doubtful = status[index_of(tick.names, interference.names)] != InterferenceStatus.VALID
        doubtful |= self._params.loading > 0.0
        eta = downwash.eta[: len(tick.names)]
        early = 0.5 + self._params.latency / self._params.step  # stages from now to the first one's middle
        now = eta[:, 0] - early * (eta[:, 1] - eta[:, 0])
        tick.table[:, ETA] = np.where(doubtful[:, None], now, tick.table[:, ETA])

    def _horizon(self, tick: Aligned, present: Present, outlook: Outlook) -> Horizon:
        push = outlook.downwash.eta[: len(tick.names)] + present.disturbance[:, None]
        low, high = self._bounds(tick)
        return Horizon(present.chains, outlook.reference, push, outlook.everyone, low, high, self._step_max)

    def _bounds(self, tick: Aligned) -> tuple[Array, Array]:
        """Return the least and largest commanded acceleration of each axis [m/s^2], (n, 3) each."""
        side = GRAVITY * math.tan(self._params.tilt_max) / math.sqrt(2.0)  # a square in the circle
        lift = self._limits.thrust_max / self._limits.mass
        low, high = bounds_of(tick.table[:, QUAT], (side, lift))
        return low, high

    def _stages(self, start: float) -> Array:
        return np.asarray(start + self._ahead, dtype=np.float64)

    def _reference(self, tick: Aligned, setpoint: SwarmSetpoint, times: Array) -> Array:
        whole = np.ascontiguousarray(shifted_preview(setpoint, self.preview, times))
        if setpoint.names == tick.names and tick.usable.all():
            return whole
        rows = index_of(tick.names, setpoint.names)
        picked = np.where((rows >= 0)[:, None, None], whole[rows], 0.0)
        return np.where(np.isfinite(picked), picked, 0.0)

    def _answered(self, tick: Aligned, horizon: Horizon, outlook: Outlook) -> Array:
        """Return each vehicle's commanded acceleration [m/s^2], world, (n, 3), and keep its plan."""
        plan, downwash = outlook.plan, outlook.downwash
        answer = self.solver.solve(horizon, downwash, plan.pattern, self._in_time)
        failed = (answer.ended == INTERRUPTED) | ~np.isfinite(answer.inputs).all(axis=(1, 2))
        age = plan.start - plan.solved
        shifted = failed & (age <= self._params.shift_time)
        by_pid = failed & ~shifted
        acc = np.where(shifted[:, None], plan.inputs[:, 0], answer.inputs[:, 0] + self._lead(horizon))
        if by_pid.any() or self._params.mode == "altitude":
            pid = self._pid_acceleration(horizon)
            acc = np.where(by_pid[:, None], pid, acc)
            if self._params.mode == "altitude":
                acc[:, :2] = pid[:, :2]
        self._keep(tick, horizon, (answer, plan), failed)
        self.report = MpcReport(
            solved=int((~failed).sum()),
            cut_off=int((answer.ended == CUT_OFF).sum()),
            shifted=int(shifted.sum()),
            pid=int(by_pid.sum()),
            iterations=answer.iterations,
            pairs=len(downwash.i),
        )
        return acc

    def _lead(self, horizon: Horizon) -> Array:
        """Return what is added to the first inputs because they act for a tick and not for their stage.

        An input answers the mean downwash and reference of its stage, half a stage ahead; the command acts
        half a tick ahead. What lies between is taken from the trend of u*, (n, 3) [m/s^2].
        """
        step = self._params.step
        early = 0.5 * max(step - TICK, 0.0) / step
        rise = horizon.reference[:, 1, 6:9] - horizon.reference[:, 0, 6:9]
        return np.asarray(early * (horizon.push[:, 1] - horizon.push[:, 0] - rise))

    def _keep(
        self, tick: Aligned, horizon: Horizon, plans: tuple[HorizonSolution, Plan], failed: Array
    ) -> None:
        answer, old = plans
        offset, solved = answer.pos - horizon.reference[..., :3], np.full(len(failed), old.start)
        inputs, pattern = answer.inputs, answer.pattern
        if failed.any():
            row = failed[:, None, None]
            offset, solved = np.where(row, old.offset, offset), np.where(failed, old.solved, solved)
            inputs, pattern = np.where(row, old.inputs, inputs), np.where(row, old.pattern, pattern)
        self._plans.keep(
            tick.names, replace(old, offset=offset, inputs=inputs, pattern=pattern, solved=solved)
        )
        told = answer.pos if not failed.any() else horizon.reference[..., :3] + offset
        self.told = Predictions(tick.names, self._stages(old.start), told)

    def _pid_acceleration(self, horizon: Horizon) -> Array:
        """Return the acceleration by a PD law of the same bandwidths, downwash and disturbance taken off."""
        w = np.array([self._params.bandwidth_xy, self._params.bandwidth_xy, self._params.bandwidth_z])
        ref, now = horizon.reference[:, 0], horizon.start
        feedback = w**2 * (ref[:, :3] - now[..., 0]) + np.sqrt(2.0) * w * (ref[:, 3:6] - now[..., 1])
        wanted = ref[:, 6:9] + feedback - horizon.push[:, 0]
        return np.asarray(np.clip(wanted, horizon.low, horizon.high))

    def _command(self, tick: Aligned, acc: Array) -> SwarmCommand:
        values, saturated = command_rows(acc, tick.table, self._numbers)
        return self._rows.completed(tick, values, saturated | (values[:, 0] >= self._nearly_full))
