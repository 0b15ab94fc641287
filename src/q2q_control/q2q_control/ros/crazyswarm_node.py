"""Crazyswarm node: bridge to Crazyswarm2: converts poses, publishes setpoints, calls the server's services.

| topic or service | direction | content or use |
|---|---|---|
| `poses_in` (NamedPoseArray) | in | published as `mocap`, without vehicles that are in one message twice |
| `poses_out` (NamedPoseArray, deadline 10 ms) | out | `state` if tracked; of single markers, position only |
| `<name>/cmd_full_state` (FullState) | out | `reference_safe`; if aware, with acc = acc_ref - eta |
| `<name>/cmd_vel_legacy` (Twist) | out, in mode command | `command`; signs by `backend`; first thrust 0 |
| `<name>/arm`, `takeoff`, `land`, `notify_setpoints_stop` | out, as a client | the flight procedure |
| `all/emergency` | out, as a client | the flight procedure; stops all vehicles of the server |
| `<name>/status`, `<name>/onboard`, the server's parameters | in | checks before a take-off |

The services `~/take_off`, `~/fly`, `~/hold`, `~/land` and `~/emergency` call the flight procedure
(docs/real_vehicles.md). Each answers when its action is complete, or with the reason for a refusal;
`procedure/status` has the step, and the checks that are impossible because the server does not report the
values. Setpoints are published only between `~/fly` and the landing. `~/arm`, `~/disarm` and
`~/notify_setpoints_stop` forward a request to the server, on the ground only. The node does not command
vehicles of the server that are not its own; only `~/emergency` stops them, too.

Without motion_capture_tracking_interfaces no poses are converted, and without crazyflie_interfaces no vehicle
is flown: the node logs a warning, and does not start if both are missing. Set `legacy_hz:=0` on the
controller if this node publishes `cmd_vel_legacy`.

A flight is refused

- if the server lacks a service that the flight needs;
- if several nodes publish an input, such as `poses_in`, where all vehicles must be in one message;
- if a configured vehicle has never appeared in `poses_in` while unknown names do;
- if the server does not subscribe to `poses_out` with a `poses_qos_deadline` (in its server.yaml) of 100 Hz,
  the default, or less.

If the node is ended in flight (SIGINT, SIGTERM, SIGHUP), it stops the setpoints, lets the server land the
vehicles where they are, and waits until they are down, for the duration of the landing and `step_timeout_s`
at most.
The server must keep running until then: without it the vehicles fall 2 s after the last setpoint.

With `--dry-run` calls are checked and answered, but not executed: vehicles do not arm, take off, follow
setpoints or land. Only `~/emergency` is executed: it stops the motors. Poses are converted, and the server
sets firmware parameters and sends poses as usual.
"""

from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_model.ros.node.run import run


def main() -> None:
    """Run the node `crazyswarm`."""
    run("crazyswarm", Crazyswarm, land=Crazyswarm.land)
