"""CRTP room without ROS, flown in real time."""

import signal
import sys
from argparse import Namespace
from contextlib import suppress
from time import monotonic, sleep
from types import FrameType

from q2q_model.signals.stamps import TICK_S
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in, unflown_faults
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams
from q2q_sim.loop.room import Room
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_firmware

LATE_S = 0.5
"""Delay behind the wall clock at which its schedule restarts [s]."""


def run(args: Namespace) -> int:
    """Open the room and fly it until SIGINT or SIGTERM; return the exit status."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _interrupt)
    with suppress(KeyboardInterrupt):
        _open(args)
    return 0


def _open(args: Namespace) -> None:
    scenario = with_firmware(library.load(args.scenario), args.firmware)
    room = Room(scenario, args.seed)
    waiting = CrtpRoomParams(
        start=args.start,
        positioning=args.positioning,
        app=str(args.app or ""),
        zero_expires=args.zero_expires,
    )
    fleet = fleet_in(room, scenario, waiting)
    if jams := unflown_faults(scenario):
        print(f"crtp: {jams}", file=sys.stderr)
    link = SharedRadioParams(latency=args.latency, loss=args.loss, rate=args.rate)
    room.fly(fleet.fly)  # compiles
    with CrtpEndpoint(fleet, args.port, link, seed=args.seed) as endpoint:
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
