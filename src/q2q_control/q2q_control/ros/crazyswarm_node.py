"""Crazyswarm node: bridge to Crazyswarm2; poses in and out, setpoints out, services as clients.

| topic or service | direction | made of |
|---|---|---|
| `poses_in` (NamedPoseArray) | in | `mocap`, without vehicles that are named twice |
| `poses_out` (NamedPoseArray, deadline 10 ms) | out | `state` if measured; lone markers without orientation |
| `<name>/cmd_full_state` (FullState) | out | `reference_safe`, minus `interference`'s acceleration if aware |
| `<name>/cmd_vel_legacy` (Twist) | out, in mode command | `command`; signs by `backend`; first thrust 0 |
| `<name>/arm`, `takeoff`, `land`, `notify_setpoints_stop` | out, as a client | the procedure |
| `all/emergency` | out, as a client | the procedure: stops all vehicles of the server |
| `<name>/status`, `<name>/onboard`, the server's parameters | in | checks before a take-off |

Vehicles fly by one procedure (q2q_control.flight_procedure.state_machine): `~/take_off`, `~/fly`, `~/hold`,
`~/land`, `~/emergency`, each answered when it is done, or with the reason of a refusal; `procedure/status`
has the step, and what cannot be checked as the server does not report it. Setpoints are sent only from the
hand-over after `~/fly` to the landing. `~/arm`, `~/disarm` and `~/notify_setpoints_stop` forward a request to
the server, on the ground only. Vehicles of the server that this node does not fly are left alone. Without
motion_capture_tracking_interfaces no poses pass, without crazyflie_interfaces nothing is flown: a warning
says so, and with neither the node does not start. Set `legacy_hz:=0` on the controller if this node sends
`cmd_vel_legacy`. `--dry-run` sends nothing.

No flight begins while the server lacks a service that it needs; while several nodes write an input, as
`poses_in`, whose vehicles must come in one message; while `poses_in` has other names than those of vehicles
that it never had; or while the server does not read `poses_out`. The server reads it with a
`poses_qos_deadline` (in its server.yaml) of 100 Hz, which is its default, or less.

A node that is ended in flight (SIGINT, SIGTERM) stops the stream and lets the vehicles land where they are,
by the server; it waits until they are down, for the duration of the landing and `step_timeout_s` at most. The
server must outlive it: without it the vehicles fall 2 s after the last setpoint.
"""

from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_model.ros.node.run import run


def main() -> None:
    """Run the node `crazyswarm`."""
    run("crazyswarm", Crazyswarm, land=Crazyswarm.land)
