"""Checks before take-off and before flying setpoints, each naming the vehicle and the value.

Every check returns the reason of its refusal, empty if there is none. Order: links, batteries,
parameters, controller, motion capture, estimators, thrust, positions, the plan, the room.
"""

from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

from q2q_control.flight_procedure.observation import Observation, VehicleReport
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_model.counted import difference, listed
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.values import Array

AXES = "xyz"
CUT_REMEDY = (
    "(all/emergency or no measurements): restart it; after missing measurements, setting stamps back by "
    f"more than {SET_BACK_S:g} s is enough"
)


def connection_refusal(observation: Observation) -> str:
    """Return which vehicles are not connected."""
    offline = [one.name for one in observation.vehicles if not one.connected]
    return f"{listed(offline)} offline: check URI, battery and radio" if offline else ""


def cut_refusal(observation: Observation) -> str:
    """Return whose motors the controller has cut; its commands carry them no more."""
    cut = listed(observation.cut)
    return f"the controller has cut {cut} {CUT_REMEDY}" if cut else ""


def take_off_refusal(observation: Observation, params: FlightProcedureParams, landing: LandingParams) -> str:
    """Return why vehicles on the ground may not take off."""
    checks: tuple[Callable[[], str], ...] = (
        lambda: connection_refusal(observation),
        lambda: _first(_vehicle_refusal(one, params) for one in observation.vehicles),
        lambda: cut_refusal(observation),
        lambda: state_refusal(observation, landing),
        lambda: attitude_refusal(observation),
        lambda: _first(_estimates(observation, params)),
        lambda: _first(_thrust(one, params) for one in observation.vehicles),
        lambda: _first(_standing(observation, params)),
        lambda: apart_refusal(observation.names, observation.pos, params.horizontal_separation_min),
        lambda: _first(_places(observation, params)),
        lambda: room_refusal(observation, params),
    )
    return _first(check() for check in checks)


def airborne_refusal(observation: Observation) -> str:
    """Return why vehicles may not go from a hover or a hold to the plan: one does not fly with the others."""
    grounded = [one.name for one in observation.vehicles if one.airborne is False]
    return (
        connection_refusal(observation)
        or _first(_lock_refusal(one) for one in observation.vehicles)
        or (f"{listed(grounded)} not flying: land all, then call take_off" if grounded else "")
    )


def join_refusal(observation: Observation, params: FlightProcedureParams, landing: LandingParams) -> str:
    """Return why vehicles may not fly the present setpoints from their positions."""
    return (
        connection_refusal(observation)
        or _first(_vehicle_refusal(one, params) for one in observation.vehicles)
        or cut_refusal(observation)
        or state_refusal(observation, landing)
        or attitude_refusal(observation)
        or setpoint_refusal(observation, params.start_tolerance, landing)
    )


def state_refusal(observation: Observation, landing: LandingParams) -> str:
    """Return which vehicle has no fresh state."""
    ages = zip(observation.names, observation.age.tolist(), strict=True)
    return _first(stale_refusal(name, age, landing.stale_s) for name, age in ages)


def stale_refusal(name: str, age: float, stale_s: float) -> str:
    """Return that a vehicle's state, `age` [s] old, is stale; empty if it is not."""
    if age <= stale_s:
        return ""
    found = f"its last is {age:.2f} s old" if np.isfinite(age) else "it was never measured"
    return f"{name} has no state younger than {stale_s:g} s ({found}): check motion capture"


def attitude_refusal(observation: Observation) -> str:
    """Return which vehicles have no attitude to fly by."""
    turned = listed(observation.without_attitude)
    remedy = "check the order x, y, z, w of quaternions and its markers"
    return f"{turned} was never measured upright: {remedy}" if turned else ""


def setpoint_refusal(observation: Observation, near: float, landing: LandingParams) -> str:
    """Return which vehicle has no fresh setpoint, or one farther than `near` [m]."""
    if not observation.setpoint_age <= landing.stale_s:
        return f"no setpoint younger than {landing.stale_s:g} s: start trajectory and replanner"
    for name, far in zip(
        observation.names,
        np.linalg.norm(observation.pos - observation.setpoint_pos, axis=1).tolist(),
        strict=True,
    ):
        if not far <= near:
            found = f"is {far:.2f} m from its setpoint" if np.isfinite(far) else "has no setpoint"
            return f"{name} {found} (maximum {near:.2f} m): call take_off, then fly"
    return ""


def room_refusal(observation: Observation, params: FlightProcedureParams) -> str:
    """Return which vehicle the waiting plan would lead out of the room."""
    return _first(_extent(observation, params))


def apart_refusal(names: tuple[str, ...], pos: Array, apart: float) -> str:
    """Return which pair is too close horizontally."""
    for first, second in combinations(range(len(names)), 2):
        gap = float(np.hypot(*(pos[first] - pos[second])[:2]))
        if gap < apart:
            return f"{names[first]} and {names[second]} are {gap:.2f} m apart (minimum {apart:.2f} m)"
    return ""


def unchecked(observation: Observation) -> str:
    """Return what could not be checked because vehicles do not report it; empty if all could."""
    silent: dict[str, Callable[[VehicleReport], bool]] = {
        "battery": lambda one: bool(np.isnan(one.volt)),
        "parameters": lambda one: one.wrong is None,
        "own estimate": lambda one: one.onboard is None,
        "thrust scale": lambda one: bool(np.isnan(one.hover_ratio)),
    }
    of = {
        what: [one.name for one in observation.vehicles if is_silent(one)]
        for what, is_silent in silent.items()
    }
    missing = [f"{what} of {listed(names)}" for what, names in of.items() if names]
    return f"not checked: {'; '.join(missing)}" if missing else ""


def _lock_refusal(one: VehicleReport) -> str:
    return f"{one.name} is locked: restart it" if one.locked else ""


def _vehicle_refusal(one: VehicleReport, params: FlightProcedureParams) -> str:
    if one.locked:
        return _lock_refusal(one)
    if np.isnan(one.volt) and params.voltage_start > 0.0:
        return f"{one.name} does not report its battery: wait for its first report, or enable its log"
    if one.volt < params.voltage_start:
        return f"{one.name} has {one.volt:.2f} V (minimum {params.voltage_start:.2f} V to start)"
    return f"{one.name}: {one.wrong}" if one.wrong else ""


def _estimates(observation: Observation, params: FlightProcedureParams) -> Iterator[str]:
    for one, pos in zip(observation.vehicles, observation.pos, strict=True):
        if one.onboard is None:
            continue
        far = float(np.linalg.norm(np.array(one.onboard) - pos))
        if np.isnan(one.onboard).any():
            yield f"{one.name} stopped sending its own estimate x, y, z: check its link and its log topics"
        if not far <= params.estimator_error:
            bound = f"(maximum {params.estimator_error:.2f} m): check frames, wait for its estimator"
            yield f"{one.name} estimates itself {far:.2f} m from its measured position {bound}"


def _thrust(one: VehicleReport, params: FlightProcedureParams) -> str:
    if np.isnan(one.hover_ratio) or abs(one.hover_ratio - 1.0) <= params.hover_mismatch:
        return ""
    sent = f"would be sent {100.0 * one.hover_ratio:.0f} % of the thrust at which it hovers"
    allowed = f"(allowed within {100.0 * params.hover_mismatch:.0f} %)"
    return f"{one.name} {sent} {allowed}: check `vehicle`, `firmware`, ctrlMel.mass and ctrlMel.massThrust"


def _standing(observation: Observation, params: FlightProcedureParams) -> Iterator[str]:
    heights, speeds = observation.pos[:, 2] - params.ground_height, np.linalg.norm(observation.vel, axis=1)
    for name, height, speed in zip(observation.names, heights.tolist(), speeds.tolist(), strict=True):
        if not abs(height) <= params.near_ground:
            yield f"{name} is {height:.2f} m above the ground: it must stand on it; set `ground_height`"
        if not speed <= params.still_speed:
            yield f"{name} moves at {speed:.2f} m/s: it must stand still"


def _places(observation: Observation, params: FlightProcedureParams) -> Iterator[str]:
    if observation.plan is None:
        yield "no plan is waiting: start trajectory with a plan and wait:=true"
        return
    if wrong := difference(observation.plan.names, observation.names):
        yield f"the plan {wrong}: the vehicles are {listed(observation.names)}"
        return
    off = observation.pos[:, :2] - observation.first_points()[:, :2]
    for name, far in zip(observation.names, np.linalg.norm(off, axis=1).tolist(), strict=True):
        if not far <= params.start_tolerance:
            yield f"{name} is {far:.2f} m from its first point (maximum {params.start_tolerance:.2f} m)"


def _extent(observation: Observation, params: FlightProcedureParams) -> Iterator[str]:
    if observation.plan is None:
        return
    low, high = np.array(params.room[:3]), np.array(params.room[3:])
    for row, name in enumerate(observation.plan.names):
        for axis in range(3):
            least, most = float(observation.plan.low[row, axis]), float(observation.plan.high[row, axis])
            if least < low[axis] or most > high[axis]:
                reach = f"{AXES[axis]} from {least:.2f} to {most:.2f} m"
                yield f"{name} would fly {reach}: the room is {low[axis]:g} to {high[axis]:g} m"


def _first(reasons: Iterator[str]) -> str:
    return next((reason for reason in reasons if reason), "")
