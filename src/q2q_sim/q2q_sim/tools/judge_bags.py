"""Check of recorded flights against the safety policies."""

import sys
from argparse import Namespace
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from q2q_model.documents.json_file import Json, write_json
from q2q_model.identification.push.recorded_push import CommandedThrust, check_thrust
from q2q_model.recordings.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.signals.values import TrackStatus
from q2q_model.vehicle.constants import VEHICLE_OPTION
from q2q_model.writable_places import STDOUT
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.flight_bag.scenario_facts import flown_faults
from q2q_sim.monitors.policies import (
    NEEDS,
    POLICIES,
    Circumstances,
    FlightTrace,
    Violation,
    judge,
    policies_without_evidence,
)
from q2q_sim.scenarios import library

VIOLATED, NOT_JUDGED = 1, 2
"""Exit statuses; 2 is that of a bag that cannot be read, too."""


@dataclass(frozen=True, slots=True)
class JudgedBag:
    """Violations in a bag, and the policies of which it has no evidence."""

    violations: tuple[Violation, ...]
    unjudged: tuple[str, ...]

    @property
    def is_empty(self) -> bool:
        """Return whether there was nothing to judge: what needs no signal is kept by a bag without any."""
        return not self.violations and NEEDS.keys() <= {*self.unjudged}

    def lines(self) -> list[str]:
        """Return the violations, or the policies that are kept."""
        if self.is_empty:
            return ["nothing to judge: record state or truth, reference_safe and command"]
        kept = [policy for policy in POLICIES if policy not in self.unjudged]
        return [str(one) for one in self.violations] or [f"keeps {', '.join(kept)}"]


def run(args: Namespace) -> int:
    """Check the named bags; return 1 if a policy is violated, else 2 if a bag has nothing to judge."""
    found = {}
    for bag in args.bags:
        trace, around = trace_in(bag), circumstances_of_bag(bag, args.scenario, args.vehicle)
        height = np.where(np.isfinite(trace.true_pos), trace.true_pos, trace.state_pos)[..., 2]
        check_thrust(CommandedThrust(str(bag), trace.names, height, trace.thrust), around.vehicle)
        found[str(bag)] = judge_bag(trace, around)
    if args.json:
        write_json(as_json(found), STDOUT)
    else:
        for bag, one in found.items():
            print("\n".join(f"{bag}: {line}" for line in one.lines()))
    for bag, lacking in ((bag, one.unjudged) for bag, one in found.items() if one.unjudged):
        print(f"policies: {bag}: not judged, as not recorded: {', '.join(lacking)}", file=sys.stderr)
    if any(one.violations for one in found.values()):
        return VIOLATED
    return NOT_JUDGED if any(one.is_empty for one in found.values()) else 0


def judge_bag(trace: FlightTrace, circumstances: Circumstances) -> JudgedBag:
    """Return how a flight keeps the policies; without true positions by the filtered ones.

    The filtered position of a lost vehicle does not count: it is where it was last seen, or the origin.
    """
    if np.isfinite(trace.true_pos).any():
        return JudgedBag(judge(trace, circumstances), policies_without_evidence(trace))
    lost = (trace.state_status == TrackStatus.LOST)[..., None]
    filtered = replace(trace, true_pos=np.where(lost, np.nan, trace.state_pos))
    policies = {name: policy for name, policy in POLICIES.items() if name != "state_error"}
    lacking = {*policies_without_evidence(filtered), "state_error"}
    return JudgedBag(
        judge(filtered, circumstances, policies), tuple(name for name in POLICIES if name in lacking)
    )


def circumstances_of_bag(bag: Path, scenario: str, vehicle: str) -> Circumstances:
    """Return the circumstances of a flight: vehicle and faults are the bag's, faults a scenario's if given.

    A bag without a vehicle has the scenario's, or the default one, and a line on stderr says so.

    Raises:
        ValueError: an unknown name.
    """
    flown = library.load(scenario) if scenario else None
    known = flown_vehicle(bag, vehicle)
    if known.note and flown is not None:
        note = f"{bag} does not name its vehicle: {flown.vehicle.name} of the scenario is assumed; "
        known = FlownVehicle(flown.vehicle, f"{note}name it with {VEHICLE_OPTION}")
    if known.note:
        print(f"policies: {known.note}", file=sys.stderr)
    return Circumstances(vehicle=known.vehicle, faults=flown_faults(bag) if flown is None else flown.faults)


def as_json(found: Mapping[str, JudgedBag]) -> Json:
    """Return the violations in each bag as plain values; NaN where unknown."""
    return {bag: [asdict(violation) for violation in one.violations] for bag, one in found.items()}
