"""Radio node: `command` or `reference_safe` in, packets out over cflib; pose, battery, link quality back.

| mode | inputs | sent every tick |
|---|---|---|
| command | `command`, `state` | roll, pitch, yaw rate, thrust |
| setpoint | `reference_safe`, `state`, and `interference` if aware | full state with acc = acc_ref - eta |

Vehicles fly by one procedure (q2q_control.flight_procedure.state_machine): `~/take_off`, `~/fly`, `~/hold`,
`~/land`, `~/emergency` (motors off and locked; also as `~/stop` and, in setpoint mode, where no controller
has it, as `all/emergency`). Each answers when it is done, or with the reason of a refusal; `procedure/status`
has the step. `~/start` is for vehicles already held at their setpoints. q2q_control.radio.pilot.vehicle_pilot
lists automatic actions, as without commands; when DDS reports that their writer is gone, it checks at once.
`--dry-run` sends nothing.
"""

from q2q_control.ros.radio_wiring import RadioNode
from q2q_model.ros.node.run import run


def main() -> None:
    """Run the node `radio`."""
    run("radio", RadioNode, RadioNode.close, land=RadioNode.land)
