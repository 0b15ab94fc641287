"""Radio node: flies vehicles over cflib by `command` or `reference_safe`; pose, battery, link quality out.

| mode | inputs | sent to each flying vehicle every tick |
|---|---|---|
| command | `command`, `state` | roll, pitch, yaw rate, thrust |
| setpoint | `reference_safe`, `state`, and `interference` if aware | full state with acc = acc_ref - eta |

The services `~/take_off`, `~/fly`, `~/hold`, `~/land` and `~/emergency` call the flight procedure
(docs/real_vehicles.md). Each answers when its action is complete, or with the reason for a refusal;
`procedure/status` has the step. `~/emergency` stops and locks the motors; `~/stop` is the same, and so is
`all/emergency` in mode setpoint, where no controller node provides it, and in a dry run. `~/start` flies
vehicles that are already at their setpoints, such as simulated ones that start in the air.

From the connection on, the node sets firmware parameters (`firmware_params`, stabilizer.controller) and, with
`places`, sends each vehicle the poses in which it was measured.

If commands stop, a flying vehicle is levelled, then landed (`command_timeout_*`); in mode command and without
measurements it sinks instead, and its motors are stopped at last. With a low battery it is landed.
q2q_control.radio.pilot.vehicle_pilot lists all automatic actions.

With `--dry-run` calls are checked and answered, but not executed: vehicles do not arm, take off, follow
setpoints or land. Only `~/emergency`, `~/stop` and `all/emergency` are executed: they stop the motors. Poses
and firmware parameters are sent, except to a vehicle that is flying when it is connected: the log says so,
and they are sent once it has landed.
"""

from q2q_control.ros.radio_wiring import RadioNode
from q2q_model.ros.node.run import run


def main() -> None:
    """Run the node `radio`."""
    run("radio", RadioNode, RadioNode.close, land=RadioNode.land)
