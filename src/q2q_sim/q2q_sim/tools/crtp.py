"""Command line of a room that speaks CRTP without ROS: `crtp SCENARIO`.

Prints one URI a vehicle, then flies at 100 Hz of wall time until it is interrupted.
"""

import argparse
import signal
import sys
from time import monotonic, sleep
from types import FrameType

from q2q_model.thrust_map import FIRMWARES
from q2q_model.tools.command_line import CommandLine
from q2q_sim import scenarios
from q2q_sim.crtp.link_model import LinkParams
from q2q_sim.crtp.room import CrtpRoomParams, fleet_in
from q2q_sim.room import TICK_S, Room
from q2q_sim.ros.crtp_endpoint import CrtpEndpoint
from q2q_sim.scenario import with_firmware

LATE_S = 0.5
"""A room that falls behind the wall clock by this counts from anew [s]."""


def main(arguments: list[str] | None = None) -> int:
    """Open the room that the command line asks for; return the exit status."""
    asked = parser().parse_args(arguments)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _interrupt)
    try:
        _open(asked)
    except KeyboardInterrupt:
        return 0
    except (ValueError, OSError) as refusal:
        print(f"crtp: {refusal}", file=sys.stderr)
        return 1
    return 0


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("crtp", __doc__, "  ros2 run q2q_sim crtp table6 --start air")
    made.add_argument("scenario", nargs="?", default="table6", help="scenario name or YAML file")
    made.add_argument("--port", type=int, default=19850, help="first UDP port; 0 lets the system choose")
    made.add_argument("--start", default="ground", choices=("ground", "air"), help="where vehicles wait")
    made.add_argument(
        "--positioning", default="deck", choices=("deck", "external"), help="who knows the place"
    )
    made.add_argument("--firmware", default="", choices=FIRMWARES, help="thrust per PWM of the vehicles")
    made.add_argument("--latency", type=float, default=0.0, help="of the link, each way [s]")
    made.add_argument("--loss", type=float, default=0.0, help="share of transmissions lost")
    made.add_argument("--rate", type=float, default=0.0, help="packets a second of one radio; 0 is no limit")
    made.add_argument("--seed", type=int, default=0, help="seed of everything random")
    return made


def _open(asked: argparse.Namespace) -> None:
    scenario = with_firmware(scenarios.load(asked.scenario), asked.firmware)
    room = Room(scenario, asked.seed)
    fleet = fleet_in(room, scenario, CrtpRoomParams(start=asked.start, positioning=asked.positioning))
    link = LinkParams(latency=asked.latency, loss=asked.loss, rate=asked.rate)
    room.fly(fleet.fly)  # compiles
    with CrtpEndpoint(fleet, scenario.names, asked.port, link) as endpoint:
        for name, uri in zip(scenario.names, endpoint.uris, strict=True):
            print(f"{name} {uri}", flush=True)
        print("ready", flush=True)
        _fly(room, endpoint)


def _fly(room: Room, endpoint: CrtpEndpoint) -> None:
    due = monotonic()
    while True:
        room.fly(endpoint.fly)
        due = max(due + TICK_S, monotonic() - LATE_S)
        sleep(max(due - monotonic(), 0.0))


def _interrupt(_: int, __: FrameType | None) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
