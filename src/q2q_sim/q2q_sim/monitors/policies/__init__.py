"""Say what a flight may never do: safety properties, written once, judged over any flight or bag.

    signals (of a bag, or of closed_loop) -> Evidence -> judge(evidence, circumstances) -> violations

| policy | property | on |
|---|---|---|
| separation | every pair stays `separation` apart | true positions |
| zone | a pair whose setpoints keep clear of the zone by `stray` is not in it | true positions |
| room | every vehicle stays within `stray_room` of where it is sent; landing is sent down | true positions |
| floor | no vehicle touches the floor that is sent above it; landing is sent down | true positions |
| thrust | 0 <= U1 <= the vehicle's largest | commands |
| tilt | thrust is commanded within tilt_max of the vertical | commands |
| numbers | nothing in a state, setpoint or command is NaN or infinite | all |
| age | a command that calls itself computed rests on a state younger than `fresh` | commands, states |
| action | a vehicle unseen for 60 ms is flown as one | frames, commands |
| silence | live: no 60 ms without a new command | commands |
| belief | a state said to be tracked is true to `belief`, where no sensor lies steadily | states |
| return | `settle` after the last trouble all are back within `back` of their setpoints | true positions |
"""

from q2q_sim.monitors.policies.evidence import Evidence, RecordedSignal, evidence_of
from q2q_sim.monitors.policies.judgement import POLICIES, judge
from q2q_sim.monitors.policies.violations import Circumstances, Limits, Violation

__all__ = [
    "POLICIES",
    "Circumstances",
    "Evidence",
    "Limits",
    "RecordedSignal",
    "Violation",
    "evidence_of",
    "judge",
]
