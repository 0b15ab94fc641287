"""Receding-horizon control with predicted downwash: (26), solved in every tick.

Every tick: the state in which a command given now finds the vehicles (latency, lags, disturbance:
`initial_state`); references, last solutions and the downwash along their paths (`forecast`); the inputs that
keep the vehicles nearest to their references within thrust, tilt and their rates (`horizon_solver`); the
first of them, or a fallback, as acceleration (`commanded_acceleration`), and as thrust, roll and pitch.

    minimise sum_k sum_j (r_j(t_k) - r_j,ref(t_k))^2 + (effort)      of (26), for all vehicles that interact
    v' = a + eta(r, r(t - tau)) + d,   a' = (u - a) / T              downwash linear along the last prediction
    d' = -w / T_w                                                    w: residual, if accelerometers correct
    f m g <= U1 <= U_max, |tilt| <= tilt_max, both with bounded rates          f: LEAST_THRUST

One linearisation and one solve per tick (real-time iteration; Diehl, Bock, Schloeder, SIAM J. Control Optim.
43, 2005): the next tick continues from this one's paths. The downwash depends on all paths, so the upper
vehicle may rise to spare the lower one: this is the benefit of joint control (Table 7).

A vehicle without usable state or setpoint is commanded by q2q_control.failsafe.last_commands: HOLD, then
LEVEL.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_control.attitude.thrust_vector import ThrustLimits, largest_thrust
from q2q_control.failsafe.last_commands import HoldThenLevel, LastCommands
from q2q_control.inputs.alignment import QUAT, Aligned, align
from q2q_control.inputs.preview import ReferencePreview, shifted_preview
from q2q_control.mpc.commanded_acceleration import MpcReport, commanded_acceleration, plain_command_rule
from q2q_control.mpc.correction import faded_residual, thrust_reserve, with_correction_bandwidth
from q2q_control.mpc.limited_command import CommandLaw, limited_command
from q2q_control.mpc.neighbours.constant_velocity import Neighbours, at_constant_velocity
from q2q_control.mpc.neighbours.exchanged_paths import (
    PredictedPaths,
    ReceivedPredictions,
    blend,
    known_neighbours,
    usable_prediction,
)
from q2q_control.mpc.prediction.downwash_horizon import GradientRule
from q2q_control.mpc.prediction.forecast import Forecast, Forecaster, correct_downwash, future_reference
from q2q_control.mpc.prediction.initial_state import InitialState, InitialStateEstimator
from q2q_control.mpc.problem.axis_model import axis_models
from q2q_control.mpc.problem.horizon import Horizon
from q2q_control.mpc.problem.input_bounds import AccelerationLimits, input_bounds
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.horizon_solver import InTime, Solver, coupled_axes, horizon_solver
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.repeated_stamp import is_repeated
from q2q_model.signals.values import (
    Array,
    Interference,
    Names,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
)
from q2q_model.vehicle.constants import GRAVITY, Vehicle

SolverFactory = Callable[[MpcParams, Vehicle], Solver]


def _always() -> bool:
    return True


@dataclass(frozen=True, slots=True)
class MpcSetup:
    """Surroundings of an Mpc: vehicles, time budget, references and solver."""

    vehicles: Names = ()
    """Vehicles to control; empty for all of the setpoint."""
    in_time: InTime = _always
    """Called before each problem of a tick; False ends the tick's solving."""
    preview: ReferencePreview | None = None
    """Future references; None extrapolates each setpoint."""
    solver: SolverFactory = horizon_solver
    residual_process: ResidualProcess | None = None
    """Residual of `model` that positions and accelerometers (`sense`) correct; None observes disturbances."""
    exchange_period: float = 0.0
    """Time between predictions of another vehicle's MPC (`Mpc.receive`) [s]; 0 extrapolates such vehicles."""


class PredictedTick(NamedTuple):
    """Tick of an Mpc, and what it predicts."""

    tick: Aligned
    reference: Array
    """Position, velocity and acceleration at each stage, world, (n, N + 1, 9)."""
    offset: Array
    """Position from the reference [m], (n, N + 1, 3)."""
    times: Array
    """Of the stages [s], (N + 1,)."""


class Mpc:
    """Receding-horizon controller with its last solutions, thrust and disturbance estimates."""

    def __init__(
        self, params: MpcParams, vehicle: Vehicle, model: InteractionModel, setup: MpcSetup | None = None
    ) -> None:
        """Control vehicles like `vehicle`; `model` is the downwash as the controller knows it."""
        self._vehicle, self._model, self._setup = vehicle, model, setup or MpcSetup()
        self._preview = self._setup.preview
        self.configure(params)

    def configure(self, params: MpcParams) -> None:
        """Use other parameters; last solutions and estimates are reset.

        Raises:
            ValueError: the solver is not made for these parameters, or thrust_max does not carry the vehicle.
        """
        if self._setup.residual_process is not None:
            params = with_correction_bandwidth(params)
        thrust_max = largest_thrust(self._vehicle, params.thrust_max if params.thrust_limited else None)
        self._solver = self._setup.solver(params, self._vehicle)
        self._params = params
        limits = ThrustLimits(
            mass=self._vehicle.mass,
            thrust_max=thrust_max,
            tilt_max=params.tilt_max,
            exact=True,
            k_yaw=params.k_yaw,
            yaw_rate_max=params.yaw_rate_max,
        )
        side = GRAVITY * math.tan(params.tilt_max) / math.sqrt(2.0)  # a square in the circle
        self._acceleration_limits = (*AccelerationLimits(side, thrust_max / self._vehicle.mass),)
        axes = axis_models(params, self._vehicle)
        share = np.array([1.0 - float(axis.transition[2, 2]) for axis in axes])
        rates = np.array([GRAVITY * params.tilt_rate_max] * 2 + [params.thrust_rate_max])
        self._slew_max = rates * params.step / share
        hover = min(self._vehicle.hover_thrust, thrust_max)
        self._last_commands = LastCommands(HoldThenLevel(params.hold_duration, hover))
        self._law = (*CommandLaw((*limits,), thrust_max * (1.0 - 1e-9), self._last_commands.rule.numbers),)
        self._command_rule = plain_command_rule(params)
        self.reset()

    def follow(self, preview: ReferencePreview | None) -> None:
        """Take future references from `preview` from the next tick on."""
        self._preview = preview

    def reset(self) -> None:
        """Forget all memory."""
        gradients = GradientRule(coupled_axes(self._params), self._params.slope_max)
        self._forecaster = Forecaster(self._params, self._model, gradients)
        self._initial_state = InitialStateEstimator(self._params, self._vehicle, self._setup.residual_process)
        self._last_commands.reset()
        self._received = ReceivedPredictions(self._setup.exchange_period)
        self._predicted: PredictedTick | None = None
        self._last: SwarmCommand | None = None
        self.report = MpcReport()

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the downwash."""
        last, names = self._last, self._setup.vehicles or setpoint.names
        if is_repeated(last, setpoint.t, names):
            return last
        if last is not None and setpoint.t < last.t:
            self.reset()
        tick = align(state, setpoint, interference, names)
        times = self._forecaster.stages(tick.t)
        references = shifted_preview(setpoint, self._preview, times)
        reference = future_reference(tick, setpoint, references, times)
        neighbours = self._neighbours(state, setpoint, references, times)
        aware = interference is not None
        forecast = self._forecaster.forecast(tick, reference, times, neighbours, aware=aware)
        if interference is not None and (self._params.loading > 0.0 or np.count_nonzero(interference.status)):
            correct_downwash(tick, interference, forecast.downwash, self._params)
        horizon = self._horizon(tick, self._initial_state.update(tick), forecast)
        solution = self._solver.solve(
            horizon, forecast.downwash, forecast.previous.active_set, self._setup.in_time
        )
        commanded = commanded_acceleration(solution, horizon, forecast, self._command_rule)
        self._forecaster.keep(tick.names, commanded.predicted)
        self._predicted = PredictedTick(tick, reference, commanded.predicted.offset, times)
        self.report = commanded.report
        last_commands = self._last_commands.memory(tick.names)
        self._last = limited_command(tick, commanded.acc, self._law, last_commands)
        self._initial_state.sent(self._last, tick)
        return self._last

    def sense(self, imu: SwarmImu) -> None:
        """Take accelerometers of a tick; without a `residual_process` they are ignored."""
        self._initial_state.sense(imu)

    def receive(self, prediction: PredictedPaths) -> None:
        """Take a neighbour's prediction, for the ticks after its own."""
        self._received.receive(prediction)

    def has_received(self, name: str, t: float) -> bool:
        """Return whether a neighbour's prediction of a tick at t [s] or later has arrived."""
        return self._received.has(name, t)

    def silent_neighbours(self, state: SwarmState) -> Names:
        """Return the vehicles of `state` whose predictions have come and then stopped."""
        return self._received.silent(state)

    @property
    def prediction(self) -> PredictedPaths | None:
        """Return the paths of the last tick's usable vehicles; None if there are none."""
        if self._predicted is None:
            return None
        tick, reference, offset, times = self._predicted
        return usable_prediction(tick, reference[..., :3] + offset, times)

    def _neighbours(
        self, state: SwarmState, setpoint: SwarmSetpoint, references: Array, times: Array
    ) -> Neighbours:
        """Return the vehicles of other controllers, as they are predicted to move."""
        straight = at_constant_velocity(state, self._setup.vehicles or setpoint.names, times)
        if not (self._setup.exchange_period and straight.names):
            return straight
        received, share = self._received.follow(setpoint.t, straight, times)
        if (share == 1.0).all():
            return received
        return blend(received, known_neighbours(straight, setpoint, references), share)

    def _horizon(self, tick: Aligned, initial: InitialState, forecast: Forecast) -> Horizon:
        n, process = len(tick.names), self._setup.residual_process
        eta, reserve = forecast.downwash.eta[:n], np.zeros((n, self._params.steps))
        push = eta + initial.disturbance[:, None]
        if process is not None:
            push[..., 2] -= faded_residual(initial.residual, process, self._params)
            reserve = thrust_reserve(eta[..., 2], process, self._params)
        low, high = input_bounds(tick.table[:, QUAT].copy(), self._acceleration_limits, reserve)
        states = initial.states
        if not tick.all_usable:  # the others it does not command: on their references they cost nothing
            still = _on_reference(forecast.reference[:, 0], push[:, 0])
            states = np.where(tick.usable[:, None, None], states, still)
        return Horizon(states, forecast.reference, push, forecast.path, low, high, self._slew_max)


def _on_reference(reference: Array, push: Array) -> Array:
    """Return position, velocity and acceleration by thrust of each axis, (n, 3 axes, 3), on a reference.

    Args:
        reference: position [m], velocity [m/s] and acceleration [m/s^2], world, (n, 9).
        push: acceleration by others [m/s^2], world, (n, 3).
    """
    states = reference.reshape(-1, 3, 3).transpose(0, 2, 1).copy()
    states[..., 2] -= push
    return states
