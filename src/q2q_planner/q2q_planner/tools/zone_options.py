"""Zone of `plan`: by risk, of an interaction model, or of a given size; options of two are refused."""

from argparse import Namespace
from collections.abc import Sequence

from q2q_model.downwash.level_set import level_set
from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_names import NONE
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.certificate.convex_zone import LARGEST
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.zones.downwash_zone import LearnedDownwash, avoid_downwash
from q2q_planner.tools.risk_options import range_note, zone_by_risk

PAPER_ZONE = Cylinder()
"""Zone without options."""
SIZE = ("shape", "eps", "d")


def zone_of(
    asked: Namespace, swarm: Sequence[VehicleWaypoints], params: AvoidanceParams, warm: SwarmPlan | None
) -> tuple[Zone, str]:
    """Return the zone of the command line, and its description; the search has `params` and starts at `warm`.

    Raises:
        ValueError: naming the options that do not fit each other, or are out of bounds.
    """
    _check_partners(asked)
    if asked.risk is not None:
        return zone_by_risk(asked)
    if asked.cut is not None:
        return _zone_by_cut(asked, swarm, params, warm)
    return _zone_of_model(asked) if asked.model else _zone_of_size(asked)


def _check_partners(asked: Namespace) -> None:
    """Raise ValueError if an option lacks the one that it changes, or comes with one that overrules it."""
    if asked.risk is not None:
        _refuse(asked, ("cut", "threshold", *SIZE), "and --risk both choose the zone: give one of them")
        return
    _refuse(asked, ("tube", "tube_risk", "hold", "touch"), "needs --risk, whose zone it changes")
    if asked.cut is not None and not (asked.model and asked.threshold is None and asked.avoid):
        needs = "needs --model, without --threshold (which it chooses) and --no-avoid"
        raise ValueError(f"--cut {asked.cut} {needs}")
    if not asked.model:
        _refuse(asked, ("threshold",), "needs --model, the downwash that it applies to")
        return
    _refuse(asked, SIZE, "and --model both choose the zone: give one of them")
    if asked.model == NONE:
        raise ValueError(f"--model {NONE} has no downwash, so no zone: name another, or give --eps and --d")


def _refuse(asked: Namespace, names: Sequence[str], why: str) -> None:
    """Raise ValueError for the first of the options that is given."""
    for name in names:
        if getattr(asked, name) is not None:
            raise ValueError(f"--{name.replace('_', '-')} {why}")


def _zone_of_model(asked: Namespace) -> tuple[Zone, str]:
    file = find_model(asked.model)
    if asked.threshold is None:
        return file.zone, f"the zone of {asked.model}"
    words = f"level set of {asked.model} at {asked.threshold} m/s^2"
    zone = level_set(file.interaction, asked.threshold)
    return zone, words + range_note(file.interaction, asked.threshold)


def _zone_of_size(asked: Namespace) -> tuple[Zone, str]:
    eps = PAPER_ZONE.eps if asked.eps is None else asked.eps
    d = PAPER_ZONE.d if asked.d is None else asked.d
    for name, value in (("eps", eps), ("d", d)):
        if not 0.0 < value < LARGEST:
            raise ValueError(f"--{name} = {value}; must be above 0 and below {LARGEST} m")
    shape = Ellipsoid if asked.shape == "ellipsoid" else Cylinder
    return shape(eps, d), f"{asked.shape or 'cylinder'} eps {eps} m, d {d} m"


def _zone_by_cut(
    asked: Namespace, swarm: Sequence[VehicleWaypoints], params: AvoidanceParams, warm: SwarmPlan | None
) -> tuple[Zone, str]:
    file = find_model(asked.model)
    downwash = LearnedDownwash(file.interaction, file.gains or PAPER_LOOP, asked.cut)
    made = avoid_downwash(swarm, downwash, asked.reading, params, warm)
    note = range_note(file.interaction, made.zone.threshold)
    words = f"level set of {asked.model} at {made.zone.threshold:.4g} m/s^2{note}"
    return made.zone, f"{words}: {made.effect}"
