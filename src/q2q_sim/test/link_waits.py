"""Waits for a link of the node `radio` to emulated vehicles, whose time passes meanwhile."""

import os
from collections.abc import Callable
from time import monotonic

from cflib_fleet import CflibFleet
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint

ANSWER_S = 600.0
"""A link that has not connected by then does not [s]."""


def until(reached: Callable[[], bool]) -> None:
    """Wait for an event in another thread."""
    give_up = monotonic() + ANSWER_S
    while not reached():
        assert monotonic() < give_up, f"not within {ANSWER_S} s"
        os.sched_yield()


def fly_until(reached: Callable[[], bool], crazyflies: CflibFleet, endpoint: CrtpEndpoint) -> None:
    """Run ticks, and keep every client known, as a radio's polling does."""
    give_up = monotonic() + ANSWER_S
    while not reached():
        assert monotonic() < give_up, f"not within {ANSWER_S} s: {endpoint.traffic}"
        for vehicle in crazyflies.fleet.vehicles:
            for client in vehicle.clients:
                vehicle.handle(ECHO_REQUEST, client)
        endpoint.fly(crazyflies.drive)
        os.sched_yield()
