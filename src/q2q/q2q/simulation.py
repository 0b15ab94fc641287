"""Simulated flight of a scenario, as its nodes fly it in lockstep."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Literal

from q2q.argument_checks import check_flags, check_whole_number
from q2q.flight_result import FlightResult
from q2q.identified_model import ModelChoice, flown_model
from q2q.scenario_choice import AirName, ScenarioChoice, scenario
from q2q_control.controller import Controller
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.own_controller.checked_controller import CheckedController
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.air.checked_wake import CheckedWake
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.faults.faults import late_fault_notes, no_size_notes
from q2q_sim.flight_bag.scenario_facts import scenario_facts
from q2q_sim.loop.closed_loop import LoopSettings, fly_blocks
from q2q_sim.loop.flight_blocks import BlockChoices, Blocks, Mode, blocks_of
from q2q_sim.monitors.policies import RecordedSignal
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import in_another_air


def fly(  # noqa: PLR0913  choices of a user, all by name
    chosen: ScenarioChoice,
    *,
    controller: str | Controller = "pid",
    aware: bool = True,
    limit: bool = True,
    model: ModelChoice | None = None,
    correct: bool = False,
    replan: Literal["none", "paper", "safe"] = "none",
    plan: SwarmPlan | None = None,
    air: AirName | FlownAir = "",
    seed: int = 0,
) -> FlightResult:
    """Fly a scenario and return the flight; the same arguments give the same numbers.

    A fault that does nothing, of size 0 or after the end, is a warning.

    Args:
        chosen: scenario, or its name, file or document; see `q2q.scenario`.
        controller: "pid", "mpc", or one of your own, which is guarded like these: an object (q2q.Controller),
            or "module:Class", made with the scenario's vehicle.
        aware: whether the predicted downwash is compensated.
        limit: whether the scenario's thrust limit applies; without it, for aware flights, only the vehicle's.
        model: interaction model of predictor and controller: an object, or a name or file as for
            `q2q.load_model`; None takes that of the scenario.
        correct: whether "pid" or "mpc" corrects the predicted downwash by positions and accelerometers.
        replan: online replanner.
        plan: flown in place of the scenario's own path, for the same vehicles and starts; see `q2q.plan`.
        air: air in place of the scenario's wake and disturbance: a name as for `q2q.scenario`, or an object
            (`q2q.load_air`, or your own q2q.Wake).
        seed: of the noise, losses and gusts; 0 or above.

    Raises:
        ValueError: a choice that is not allowed; the message says what is.
        TypeError: an argument of another type, as a controller without the methods of q2q.Controller.
        ModelOutputError, ControllerOutputError, AirError: your own model, controller or air returned
            something that cannot be flown with, or the air failed.
    """
    check_flags(aware=aware, limit=limit, correct=correct)
    if not (aware or limit):
        raise ValueError("limit=False with aware=False: a controller that ignores keeps the thrust limit")
    check_whole_number("seed", seed, 0)
    _check_controller(controller, correct=correct, limit=limit)
    flown = _in_air(scenario(chosen), air)
    for note in (*no_size_notes(flown.faults), *late_fault_notes(flown.faults, flown.duration)):
        warnings.warn(note, stacklevel=2)
    known = flown_model(flown.model if model is None else model)
    mode: Mode = "ignoring" if not aware else "aware" if limit else "aware_unlimited"
    choice = BlockChoices(mode, _name_of(controller), replan, correct)
    residual = known.residual or REAL_FLIGHTS
    blocks = blocks_of(flown, choice, known.interaction, plan, residual)
    if not isinstance(controller, str):
        blocks = _with_controller(blocks, controller, flown)
    signals: list[RecordedSignal] = []

    def record(topic: str, stamp_ns: int, signal: Signal) -> None:
        signals.append(RecordedSignal(topic, time_from_stamp(stamp_ns), signal))

    arrays = fly_blocks(flown, blocks, LoopSettings(mode, seed, _own_air(air), record))
    facts = replace(scenario_facts(flown, choice, seed), controller=_word(controller))
    facts = facts if model is None else replace(facts, model=_word(model))
    facts = facts if isinstance(air, AirName) else replace(facts, wake="", air=_word(air))
    return FlightResult(arrays, flown.vehicle, facts, flown.faults, tuple(signals), flown)


def _word(choice: object) -> str:
    """Return a name as it is, else that of the object's class."""
    return str(choice) if isinstance(choice, str | Path) else type(choice).__name__


def _in_air(flown: Scenario, air: AirName | FlownAir) -> Scenario:
    """Return the scenario in an air, as `fly --air` does: of two variants, that for another air.

    Raises:
        TypeError: it is no air, such as the class in place of an object of it.
        ValueError: the scenario was changed where its variant differs.
    """
    if isinstance(air, AirName):
        return scenario(flown, air=air)
    if isinstance(air, type) or not isinstance(air, FlownAir):
        raise TypeError(
            f"no air {air!r}: give a name as for q2q.scenario, an air of q2q.load_air, or one like q2q.Wake"
        )
    return in_another_air(flown)


def _own_air(air: AirName | FlownAir) -> FlownAir | None:
    if isinstance(air, AirName):
        return None
    return air if isinstance(air, WakeLaw | RoomAir) else CheckedWake(air)


def _name_of(controller: str | Controller) -> str:
    """Return the built-in controller of a choice; that of one's own takes its place."""
    return controller if isinstance(controller, str) else "pid"


def _check_controller(given: object, *, correct: bool, limit: bool) -> None:
    """Raise TypeError for what is no controller, such as the class in place of an object of it."""
    if isinstance(given, str):
        return
    if isinstance(given, type) or not isinstance(given, Controller):
        raise TypeError(f"no controller {given!r}: give pid, mpc, or an object like q2q.Controller")
    if correct:
        raise ValueError("correct=True is only for pid and mpc: your own controller must correct by itself")
    if not limit:
        raise ValueError("limit=False is only for pid and mpc: your own controller limits its thrust itself")


def _with_controller(blocks: Blocks, own: Controller, flown: Scenario) -> Blocks:
    checked = CheckedController(own, flown.vehicle)
    guarded = Guard(checked, FallbackParams(), flown.vehicle.hover_thrust)
    guarded.reset()  # what the user's object has learned in a flight before
    return replace(blocks, controller=guarded, sense=checked.sense)
