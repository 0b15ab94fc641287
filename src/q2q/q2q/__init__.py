"""Simulated flights, plans, models and campaigns in Python, without ROS.

    import q2q

    flight = q2q.fly("table6_room", air="room", controller="mpc")
    flight.arrays.true_pos              # (T, n, 3), [m], world, z up
    flight.metrics.vehicles["cf1"]      # z RMSE, thrust, ...
    flight.plot("altitude", "cf1")      # matplotlib figure

| to | call |
|---|---|
| choose or change a scenario | `scenario`, `load_air`, `dataclasses.replace` |
| fly it | `fly` |
| read a recorded flight | `read_bag` |
| draw flights together | `plot`, `page` |
| plan around the downwash | `plan` |
| identify a model | `identify`, `load_model`, `save_model` |
| fly random faults | `campaign` |

The other names are the types of what these functions take and return.
"""

from q2q.flight_result import FlightResult, page, plot, read_bag
from q2q.identified_model import identify, load_model, save_model
from q2q.planned_path import plan
from q2q.random_faults import campaign
from q2q.scenario_choice import load_air, scenario, scenario_names
from q2q.simulation import fly
from q2q_control.controller import Controller
from q2q_model.compilation.compilation_notice import give_notice_of_compilation
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.flights.flight import Flight
from q2q_model.identification.identification import Identification
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake import AirSetup, Push, Sources, Wake
from q2q_sim.campaigns.random_runs.run_outcome import RunOutcome
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, VehicleMetrics
from q2q_sim.scenarios.scenario import Scenario

__all__ = [
    "AirSetup",
    "Controller",
    "Flight",
    "FlightMetrics",
    "FlightResult",
    "FlightVerdict",
    "Identification",
    "InteractionModel",
    "Interference",
    "ModelFile",
    "Push",
    "RoomAir",
    "RunOutcome",
    "Scenario",
    "Sources",
    "SwarmCommand",
    "SwarmPlan",
    "SwarmSetpoint",
    "SwarmState",
    "VehicleMetrics",
    "Wake",
    "campaign",
    "fly",
    "identify",
    "load_air",
    "load_model",
    "page",
    "plan",
    "plot",
    "read_bag",
    "save_model",
    "scenario",
    "scenario_names",
]

give_notice_of_compilation("q2q")
