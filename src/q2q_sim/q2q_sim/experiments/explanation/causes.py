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
from q2q_sim.experiments.explanation.flight_setup import FlightSetup
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


def without_causes(setup: FlightSetup, causes: Collection[str]) -> FlightSetup:
    """Return the flight without some of CAUSES, and without their faults."""
    for cause in CAUSES:  # in one order, whatever that of `causes`
        if cause in causes:
            setup = CAUSES[cause](_without_faults(setup, FAULTS.get(cause, ())))
    return setup


def present_causes(setup: FlightSetup) -> tuple[str, ...]:
    """Return the causes that a flight contains."""
    return tuple(cause for cause in CAUSES if _differs(without_causes(setup, {cause}), setup))


def _differs(one: FlightSetup, other: FlightSetup) -> bool:
    return one.scenario != other.scenario or one.options != other.options or one.air is not other.air


def _without_faults(setup: FlightSetup, kinds: Collection[str]) -> FlightSetup:
    kept = tuple(fault for fault in setup.scenario.faults if fault.kind not in kinds)
    return replace(setup, scenario=replace(setup.scenario, faults=kept))


def _without_downwash(setup: FlightSetup) -> FlightSetup:
    still = _in_still_air(setup.air)
    gone = setup.scenario.wake != "none" if setup.air is None else still is not setup.air
    if not gone:
        return setup
    return replace(setup, scenario=replace(setup.scenario, wake="none", model="none"), air=still)


def _in_still_air(air: FlownAir | None) -> FlownAir | None:
    """Return an air without downwash; the same object if it has none."""
    if isinstance(air, RoomAir):
        return _without_terms(air, JET_TERMS)
    return air if air is None else WakeLaw.NONE


def _without_wind(setup: FlightSetup) -> FlightSetup:
    if isinstance(setup.air, RoomAir):
        return replace(setup, air=_without_terms(setup.air, ("wind",)))
    if setup.air is not None:  # a wake law: still air
        return setup
    still = replace(setup.scenario.disturbance, air_std=0.0)
    return replace(setup, scenario=replace(setup.scenario, disturbance=still))


def _without_terms(air: RoomAir, terms: Collection[str]) -> RoomAir:
    present = tuple(term for term in terms if getattr(air, term) is not None)
    return without_terms(air, present) if present else air


def _without_saturation(setup: FlightSetup) -> FlightSetup:
    strong = _strong(setup.scenario.vehicle)
    limit = {"thrust_max": strong.thrust_max}
    overrides = {**setup.scenario.overrides}
    for block in ("pid", "mpc"):
        overrides[block] = {**overrides.get(block, {}), **limit}
    even = replace(setup.scenario.disturbance, thrust_gain_min=1.0, thrust_gain_max=1.0)
    changed = replace(setup.scenario, vehicle=strong, overrides=overrides, disturbance=even)
    return replace(setup, scenario=changed, air=_in_even_air(setup.air))


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


def _without_mocap_errors(setup: FlightSetup) -> FlightSetup:
    perfect = ViconParams(latency=setup.scenario.vicon.latency)
    return replace(setup, scenario=replace(setup.scenario, vicon=perfect))


def _without_latency(setup: FlightSetup) -> FlightSetup:
    vicon = replace(setup.scenario.vicon, latency=0.0)
    radio = replace(setup.scenario.radio, latency=0.0, jitter=0.0)
    return replace(setup, scenario=replace(setup.scenario, vicon=vicon, radio=radio))


def _without_losses(setup: FlightSetup) -> FlightSetup:
    radio = replace(setup.scenario.radio, loss=0.0, rate=RadioParams().rate)
    return replace(setup, scenario=replace(setup.scenario, radio=radio))


def _with_reference_control(setup: FlightSetup) -> FlightSetup:
    own = setup.scenario.overrides.get("pid", {})
    limit = {name: value for name, value in own.items() if name == "thrust_max"}
    overrides = {**setup.scenario.overrides, "pid": limit | GAINS}
    scenario = replace(setup.scenario, overrides=overrides, model=_fitting_model(setup))
    return replace(
        setup,
        scenario=scenario,
        options=replace(setup.options, controller="pid", replan="none", correct=False),
    )


def _fitting_model(setup: FlightSetup) -> str:
    """Return the model of the flown wake; in other air, and where downwash is ignored, the flight's own."""
    law = wake_by_name(setup.scenario.wake) if setup.air is None else setup.air
    if isinstance(law, WakeLaw) and setup.options.aware:
        return BELIEFS[law]
    return setup.scenario.model


CAUSES: Mapping[str, Callable[[FlightSetup], FlightSetup]] = {
    "downwash": _without_downwash,
    "battery and saturation": _without_saturation,
    "motion capture": _without_mocap_errors,
    "latency": _without_latency,
    "lost messages": _without_losses,
    "control": _with_reference_control,
    "wind": _without_wind,
}
"""Functions that return the flight without a cause."""
