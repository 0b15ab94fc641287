"""Causes of a loss, and the flight without each of them.

| cause | taken out |
|---|---|
| downwash | wake or jet of the air with its residual, meander and torque; the controller believes in none |
| battery and saturation | limits of thrust (AMPLE in their place), battery sag, weak rotors, thrust offsets |
| motion capture | noise, outliers, dropouts, flips, swaps, wrong stamps |
| latency | of camera and radio, with its jitter; late and reordered frames |
| lost messages | lost packets, frames that repeat the last one, a packet rate below the largest |
| control | gains, replanner, correction, MPC: in their place the PID with GAINS, its model that of the wake |
| wind | gusts and steady wind |

A cause that changes nothing in a flight is absent from it. Noise, packets and gusts come from streams of
their own, so that the others meet the same draws without it.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.air_terms import VehicleTerm
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir, without_terms
from q2q_sim.air.wake_laws import WakeLaw, wake_by_name
from q2q_sim.campaigns.random_runs.random_run import GAINS
from q2q_sim.experiments.explanation.flight_case import FlightCase
from q2q_sim.link.radio import RadioParams
from q2q_sim.sensors.vicon_params import ViconParams

AMPLE = 4.0
"""Largest thrust over the weight, where thrust is no limit [-]: twice that of a Crazyflie."""
JET_TERMS = ("jet", "absorption", "meander", "residual", "edge_torque")
"""Terms of a room's air that are zero without a vehicle above."""
BELIEFS = {WakeLaw.NONE: "none", WakeLaw.PAPER: "paper_law", WakeLaw.MEASURED: "measured_law"}
"""Model that fits each wake."""
FAULTS: Mapping[str, Collection[str]] = {
    "battery and saturation": ("battery_sag", "weak_rotor"),
    "motion capture": ("outlier", "jump", "flip", "swap", "dropout", "nan", "stale", "clock_jump"),
    "latency": ("late", "reordered"),
    "lost messages": ("radio_loss", "repeated"),
}
"""Kinds of q2q_sim.faults.faults by cause."""


def without_causes(case: FlightCase, causes: Collection[str]) -> FlightCase:
    """Return the flight without some of CAUSES, and without their faults."""
    for cause in CAUSES:  # in one order, whatever that of `causes`
        if cause in causes:
            case = CAUSES[cause](_without_faults(case, FAULTS.get(cause, ())))
    return case


def present_causes(case: FlightCase) -> tuple[str, ...]:
    """Return the causes that a flight contains."""
    return tuple(cause for cause in CAUSES if _differs(without_causes(case, {cause}), case))


def _differs(one: FlightCase, other: FlightCase) -> bool:
    return one.scenario != other.scenario or one.options != other.options or one.air is not other.air


def _without_faults(case: FlightCase, kinds: Collection[str]) -> FlightCase:
    kept = tuple(fault for fault in case.scenario.faults if fault.kind not in kinds)
    return replace(case, scenario=replace(case.scenario, faults=kept))


def _without_downwash(case: FlightCase) -> FlightCase:
    still = _in_still_air(case.air)
    gone = case.scenario.wake != "none" if case.air is None else still is not case.air
    if not gone:
        return case
    return replace(case, scenario=replace(case.scenario, wake="none", model="none"), air=still)


def _in_still_air(air: FlownAir | None) -> FlownAir | None:
    """Return an air without downwash; the same object if it has none."""
    if isinstance(air, RoomAir):
        return _without_terms(air, JET_TERMS)
    return air if air is None else WakeLaw.NONE


def _without_wind(case: FlightCase) -> FlightCase:
    if isinstance(case.air, RoomAir):
        return replace(case, air=_without_terms(case.air, ("wind",)))
    if case.air is not None:  # a wake law: still air
        return case
    still = replace(case.scenario.disturbance, air_std=0.0)
    return replace(case, scenario=replace(case.scenario, disturbance=still))


def _without_terms(air: RoomAir, terms: Collection[str]) -> RoomAir:
    present = tuple(term for term in terms if getattr(air, term) is not None)
    return without_terms(air, present) if present else air


def _without_saturation(case: FlightCase) -> FlightCase:
    strong = _strong(case.scenario.vehicle)
    limit = {"thrust_max": strong.thrust_max}
    overrides = {**case.scenario.overrides}
    for block in ("pid", "mpc"):
        overrides[block] = {**overrides.get(block, {}), **limit}
    even = replace(case.scenario.disturbance, thrust_gain_min=1.0, thrust_gain_max=1.0)
    changed = replace(case.scenario, vehicle=strong, overrides=overrides, disturbance=even)
    return replace(case, scenario=changed, air=_in_even_air(case.air))


def _strong(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with ample thrust, at the same share of PWM."""
    most = max(AMPLE * vehicle.hover_thrust, vehicle.thrust_max)
    full = vehicle.full_pwm_thrust * most / vehicle.thrust_max
    return replace(vehicle, thrust_max=most, full_pwm_thrust=full)


def _in_even_air(air: FlownAir | None) -> FlownAir | None:
    """Return an air with vehicles alike and of ample thrust; the same object if they are."""
    if not isinstance(air, RoomAir) or air.vehicle is None:
        return air
    even = _even(air.vehicle)
    return air if even == air.vehicle else replace(air, vehicle=even)


def _even(term: VehicleTerm) -> VehicleTerm:
    """Return the differences between vehicles without offsets and with ample thrust."""
    return replace(
        term,
        offset_mean_mps2=0.0,
        offset_std_mps2=0.0,
        headroom=max(AMPLE, term.headroom),
        headroom_std=0.0,
        motor_std=0.0,
        discharge_v_per_s=0.0,
    )


def _without_mocap_errors(case: FlightCase) -> FlightCase:
    perfect = ViconParams(latency=case.scenario.vicon.latency)
    return replace(case, scenario=replace(case.scenario, vicon=perfect))


def _without_latency(case: FlightCase) -> FlightCase:
    vicon = replace(case.scenario.vicon, latency=0.0)
    radio = replace(case.scenario.radio, latency=0.0, jitter=0.0)
    return replace(case, scenario=replace(case.scenario, vicon=vicon, radio=radio))


def _without_losses(case: FlightCase) -> FlightCase:
    radio = replace(case.scenario.radio, loss=0.0, rate=RadioParams().rate)
    return replace(case, scenario=replace(case.scenario, radio=radio))


def _with_reference_control(case: FlightCase) -> FlightCase:
    own = case.scenario.overrides.get("pid", {})
    limit = {name: value for name, value in own.items() if name == "thrust_max"}
    overrides = {**case.scenario.overrides, "pid": limit | GAINS}
    scenario = replace(case.scenario, overrides=overrides, model=_fitting_model(case))
    return replace(
        case,
        scenario=scenario,
        options=replace(case.options, controller="pid", replan="none", correct=False),
    )


def _fitting_model(case: FlightCase) -> str:
    """Return the model of the flown wake; in other air, and where downwash is ignored, the flight's own."""
    law = wake_by_name(case.scenario.wake) if case.air is None else case.air
    if isinstance(law, WakeLaw) and case.options.aware:
        return BELIEFS[law]
    return case.scenario.model


CAUSES: Mapping[str, Callable[[FlightCase], FlightCase]] = {
    "downwash": _without_downwash,
    "battery and saturation": _without_saturation,
    "motion capture": _without_mocap_errors,
    "latency": _without_latency,
    "lost messages": _without_losses,
    "control": _with_reference_control,
    "wind": _without_wind,
}
"""Functions that return the flight without a cause."""
