"""Calls of every compiled function that flights need, with which set-up fills the cache.

Compilation takes minutes, the calls almost nothing: flights last a few ticks. Kernels that none of them
calls are named by `q2q_model.compiled.uncached_kernels`.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from q2q_control.failsafe.tracking_loss.stacking import stacked_pairs
from q2q_control.inputs.preview import resting_preview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.neighbours.exchanged_paths import ReceivedPath, accelerations_along, positions_at
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.diagnostics.smallest_separation import smallest_separation
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.downwash.source_strength import SourceTerms, strengths
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.gains.impulse_response import impulse_response
from q2q_model.model_files.find_model import find_model
from q2q_model.node.warm_up import warm_up
from q2q_model.signals.values import Interference, MocapFrame, SwarmSetpoint, SwarmState
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_model.vehicle.constants import TEXTBOOK_065
from q2q_sim.air.air_terms import JetTerm, ResidualTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.room import Room
from q2q_sim.monitors.metrics.proximity import (
    any_in_zone,
    in_zone_once,
    least_distances,
    near_sample,
    under_another,
)
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_batch import SwarmBatch, SwarmBatchSetup
from q2q_sim.scenarios import library

KernelCall = Callable[[], object]
TICKS = 0.06
"""Long enough to confirm a track [s]."""
MANY = tuple(f"cf{k}" for k in range(1, 11))
"""Swarm large enough for the spatial search of pairs."""
CONTROLLED = (SwarmState, SwarmSetpoint, Interference)


def calls() -> tuple[KernelCall, ...]:
    """Return the functions that call every kernel, those that compile for longest first."""
    long = (_mpc, _replanned, _in_a_rooms_air, _firmware)
    return *long, _room, _estimators, _nearness, _identification, _many


def _flown(scenario: str, controller: str = "pid", replan: str = "none") -> None:
    short = replace(library.load(scenario), duration=TICKS)
    known = find_model(short.model).interaction
    fly(short, FlightOptions(controller=controller, replan=replan, model=known))


def _estimators() -> None:
    block = MocapFilter(MocapFilterParams(), MANY[:2])
    warm_up(block.update, block.reset, (MocapFrame,), MANY[:2])
    predictor = InteractionPredictor(find_model("measured_law").interaction)
    warm_up(predictor.update, predictor.reset, (SwarmState,))
    two = np.array([[0], [1]])
    strengths(two[:, 0], two[::-1, 0], np.zeros((2, 1)), np.ones((2, 1)), SourceTerms(1.0, 1.0))


def _room() -> None:
    _flown("table6_room")
    _flown("stack3", replan="paper")
    fly(replace(library.load("stack3"), duration=TICKS), FlightOptions(residual_process=REAL_FLIGHTS))


def _in_a_rooms_air() -> None:
    push = np.array([[2.0, 0.0], [1.0, 0.0]])
    jet = JetTerm(np.array([0.1, 1.0]), np.array([0.0, 0.2]), push, 0.02, 7.5, 0.5, 0.5)
    air = RoomAir(jet=jet, residual=ResidualTerm(0.3, 0.1, 0.08))
    scenario = library.load("stack3")
    start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])
    swarm = Swarm(scenario.names, scenario.vehicle, start, air)
    n = len(start)
    drive = np.hstack([np.zeros((n, 3)), np.ones((n, 4))])
    swarm.step(np.zeros((1, n, 4)), drive)
    swarm.downwash()
    batch = SwarmBatch(SwarmBatchSetup(scenario.vehicle, start[None], air))
    batch.step(np.zeros((1, 1, n, 4)), drive[None])


def _replanned() -> None:
    _flown("stack3", replan="safe")  # with bounded jerk
    fly(
        replace(library.load("stack3"), duration=TICKS, overrides={}),
        FlightOptions(replan="safe"),
    )


def _many() -> None:
    _flown("swarm40", replan="safe")


def _firmware() -> None:
    scenario = library.load("table6")
    room = Room(scenario, seed=0)
    room.fly(fleet_in(room, scenario, CrtpRoomParams()).fly)


def _nearness() -> None:
    pair = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]])
    stacked_pairs(pair, np.arange(2), 0.3, 0.0)
    least_distances(pair[None])
    smallest_separation(pair)
    any_in_zone(pair[None], Cylinder())
    under_another(pair[None], 0.15, 1.5)
    in_zone_once(pair[None], Cylinder())
    near_sample(pair[None], pair[None], 0.1)


def _mpc() -> None:
    positions_at(ReceivedPath(0.0, 0.0, 1.0, np.zeros((2, 3))), np.zeros(1), np.zeros((1, 3)))
    accelerations_along(np.zeros((1, 3, 3)), np.arange(3.0))
    for model in (MEASURED_LAW, PAPER_LAW, replace(PAPER_LAW, absorption=1.0)):
        block = Mpc(MpcParams(), TEXTBOOK_065, model)
        for names in (MANY[:2], MANY):
            block.follow(resting_preview(names))
            warm_up(block.update, block.reset, CONTROLLED, names)
    among_others = Mpc(MpcParams(), TEXTBOOK_065, MEASURED_LAW, MpcSetup(MANY[:1]))
    warm_up(among_others.update, among_others.reset, CONTROLLED, MANY[:2])


def _identification() -> None:
    impulse_response(PAPER_LOOP, 0.01, 3)
    first_order_lag(np.zeros((3, 2)), np.array([0.0, 0.01, 0.02]), 0.07)
