"""Safety policies: properties that every flight must keep, checked on any flight or bag.

    signals (of a bag, or of closed_loop) -> FlightTrace -> judge(trace, circumstances) -> violations

| policy | property | on |
|---|---|---|
| separation | every pair stays `separation` apart, by more than markers are displaced | true positions |
| zone | a pair whose setpoints clear the zone by `stray` is not in it | true positions |
| setpoint_error | every vehicle is within `setpoint_error_max` of its setpoint, or lands below it | truth |
| floor | no vehicle with a setpoint above the floor touches it, unless it lands | true positions |
| thrust | 0 <= U1 <= the vehicle's largest | commands |
| tilt | thrust is commanded within tilt_max of the vertical | commands |
| numbers | no state, setpoint or command is NaN or infinite | all |
| state_age | a command with status OK is of a state younger than `state_age_max` | commands, states |
| fallback_latency | a vehicle not observed for 60 ms is flown by a fallback | frames, commands |
| silence | live: no vehicle in the air is 60 ms without a new command (`ended` at the end) | commands |
| state_error | a state marked tracked is within `state_error_max`, unless a sensor errs steadily | states |
| return | `settle` after the last fault all are within `back`, but for less than `passing` | truth |

A vehicle with too little thrust (thrust_exceeded), or flown without measurements in a downwash that nothing
predicts (unpredicted_downwash), is not judged by zone, setpoint_error, floor and return until `settle` after
it; in the second case nor by separation.
"""

from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import (
    FlightTrace,
    RecordedSignal,
    trace_in_lockstep,
    trace_of,
)
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.judgement import NEEDS, POLICIES, judge, policies_without_evidence
from q2q_sim.monitors.policies.violations import Violation

__all__ = [
    "NEEDS",
    "POLICIES",
    "Circumstances",
    "FlightTrace",
    "Limits",
    "RecordedSignal",
    "Violation",
    "judge",
    "policies_without_evidence",
    "trace_in_lockstep",
    "trace_of",
]
