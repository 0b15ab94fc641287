"""Blocks of a flight and their parameters, built from its scenario, for `closed_loop` and the nodes.

The nodes take plan and parameters from here too (node_flights.scenario_node_parameters): both fly the same.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from q2q_control.controller import Controller
from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.own_controller.find_controller import find_controller
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.level_set import peak_downwash
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.zone import Zone
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.values import SwarmImu
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.minimum_snap.feasibility import check_feasible
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.zones.downwash_zone import LearnedDownwash, avoid_downwash
from q2q_planner.online.potential_field import PotentialField, PotentialFieldParams
from q2q_planner.online.replanner import Replanner
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams
from q2q_sim.loop.flown_plan import plan_for
from q2q_sim.scenarios.block_overrides import block_params
from q2q_sim.scenarios.choices import CONTROLLERS, REPLANNERS, check_controller
from q2q_sim.scenarios.scenario import Scenario

Mode = Literal["ignoring", "aware", "aware_unlimited"]
MODES: tuple[Mode, ...] = ("ignoring", "aware", "aware_unlimited")


@dataclass(frozen=True, slots=True)
class BlockChoices:
    """Which blocks fly, and in which mode."""

    mode: str = "aware"
    controller: str = "pid"
    """pid, mpc, or module:Class of the user's own."""
    replan: str = "none"
    correct: bool = False
    """Whether positions and accelerometers correct the predicted downwash."""

    def __post_init__(self) -> None:
        """Check the values."""
        _check("mode", self.mode, MODES)
        check_controller(self.controller, correct=self.correct, limit=self.limited)
        _check("replan", self.replan, REPLANNERS)

    @property
    def aware(self) -> bool:
        """Return whether the downwash is compensated."""
        return self.mode != "ignoring"

    @property
    def limited(self) -> bool:
        """Return whether the scenario's thrust limit applies."""
        return self.mode != "aware_unlimited"


def ignore_accelerometers(_: SwarmImu) -> None:
    """Ignore the accelerometers."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """Blocks of one flight, in the order of the data flow."""

    plan: SwarmPlan
    mocap_filter: MocapFilter
    predictor: InteractionPredictor
    player: PlanPlayer
    """Plays the plan from stamp 0."""
    replanner: Replanner
    controller: Controller
    sense: Callable[[SwarmImu], None]
    """Takes the accelerometers of a tick after its command."""


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What a controller knows."""

    model: InteractionModel
    plan: SwarmPlan
    residual_process: ResidualProcess | None
    """Residual of the model; None corrects nothing."""


def plan_of(scenario: Scenario, zone: Zone | None = None) -> SwarmPlan:
    """Return the scenario's own plan, else minimum snap; with a zone, certified to keep every pair out of it.

    Raises:
        InfeasibleError: no such plan was found.
        ValueError: its own is for other vehicles, or begins elsewhere.
    """
    if zone is None and scenario.plan is not None:
        return plan_for(scenario, scenario.plan)
    if zone is None:
        return minimum_snap_plan(scenario.waypoints, scenario.reading)
    return avoid_zones(scenario.waypoints, zone, scenario.reading).plan


def plan_around(scenario: Scenario, known: ModelFile) -> SwarmPlan:
    """Return a plan certified to keep every pair out of the downwash of a learned model.

    `downwash_zone` chooses the size of the zone; a model without downwash uses the zone of its file.

    Raises:
        InfeasibleError: no such plan was found.
        NotFlyableError: the vehicles cannot fly it.
    """
    if peak_downwash(known.interaction) > 0.0:
        downwash = LearnedDownwash(known.interaction, known.gains or PAPER_LOOP)
        made = avoid_downwash(scenario.waypoints, downwash, scenario.reading).found.plan
    else:
        made = plan_of(scenario, known.zone)
    check_feasible(made, scenario.waypoints, scenario.vehicle)
    return made


def filter_params(scenario: Scenario) -> MocapFilterParams:
    """Return the mocap filter's parameters."""
    return block_params("mocap_filter", MocapFilterParams(), scenario.overrides)


def replanner_params(scenario: Scenario, *, enabled: bool) -> PotentialFieldParams:
    """Return the replanner's parameters; a disabled replanner passes setpoints through."""
    return replace(block_params("replanner", PotentialFieldParams(), scenario.overrides), enabled=enabled)


def safe_replanner_params(scenario: Scenario) -> SafeReplannerParams:
    """Return the parameters of the safe replanner."""
    return block_params("safe_replanner", SafeReplannerParams(), scenario.overrides)


def pid_params(scenario: Scenario, *, limited: bool) -> PidParams:
    """Return the PID's parameters, with or without the scenario's thrust limit."""
    return replace(block_params("pid", PidParams(), scenario.overrides), thrust_limited=limited)


def tracker_params(scenario: Scenario) -> TrackerParams:
    """Return the parameters of the PID's correction, with the room's latency."""
    return replace(TrackerParams(), latency=scenario.vicon.latency + scenario.radio.latency)


def mpc_params(scenario: Scenario, *, limited: bool) -> MpcParams:
    """Return the MPC's parameters, with the room's latency and the thrust limit if there is one."""
    latency = scenario.vicon.latency + scenario.radio.latency
    params = replace(MpcParams(), latency=latency)
    return replace(block_params("mpc", params, scenario.overrides), thrust_limited=limited)


def blocks_of(
    scenario: Scenario,
    choices: BlockChoices,
    model: InteractionModel,
    plan: SwarmPlan | None = None,
    residual: ResidualProcess = REAL_FLIGHTS,
) -> Blocks:
    """Return new blocks for a flight.

    Args:
        scenario: vehicles, path and room.
        choices: which blocks fly, and in which mode.
        model: of the predictor and the controller.
        plan: replaces the scenario's own.
        residual: of the model, for a controller that corrects.

    Raises:
        TypeError: the plan is none.
        ValueError: it is for other vehicles, or begins elsewhere.
    """
    flown = plan_of(scenario) if plan is None else plan_for(scenario, plan)
    residual_process = residual if choices.correct else None
    controller, sense = _controller(scenario, choices, Knowledge(model, flown, residual_process))
    return Blocks(
        plan=flown,
        mocap_filter=MocapFilter(filter_params(scenario), scenario.names),
        predictor=InteractionPredictor(model),
        player=PlanPlayer(flown, 0.0, TransitParams(), wait=False),
        replanner=_replanner(scenario, choices),
        controller=Guard(controller, FallbackParams(), scenario.vehicle.hover_thrust),
        sense=sense,
    )


def _replanner(scenario: Scenario, choices: BlockChoices) -> Replanner:
    if choices.replan == "safe":
        return SafeReplanner(safe_replanner_params(scenario))
    return PotentialField(replanner_params(scenario, enabled=choices.replan == "paper"))


def _controller(
    scenario: Scenario, choices: BlockChoices, known: Knowledge
) -> tuple[Controller, Callable[[SwarmImu], None]]:
    """Return a controller, and what takes its accelerometers."""
    if choices.controller == "mpc":
        preview = sampled_preview(known.plan.names, known.plan.trajectories, 0.0)
        setup = MpcSetup(preview=preview, residual_process=known.residual_process)
        mpc = Mpc(mpc_params(scenario, limited=choices.limited), scenario.vehicle, known.model, setup)
        return mpc, mpc.sense
    if choices.controller not in CONTROLLERS:
        own = find_controller(choices.controller, scenario.vehicle)
        return own, own.sense
    params = pid_params(scenario, limited=choices.limited)
    if known.residual_process is None:
        return Pid(params, scenario.vehicle), ignore_accelerometers
    pid = ObservedPid(
        params, tracker_params(scenario), scenario.vehicle, residual_process=known.residual_process
    )
    return pid, pid.sense


def _check(what: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"unknown {what} {value!r}: choose one of {', '.join(known)}")
