"""CPU cores of a flight's nodes.

Within a tick most nodes wait for each other: simulator, mocap_filter, interference, controller, simulator.
Under the scheduler they migrate between cores with cold caches; pinned to one core of their own a tick takes
a quarter less. Nodes outside the chain (trajectory, replanner, recorder) use all other cores. Distributed
MPC nodes compute at the same time and use all cores (q2q_sim.node_flights.flight_nodes).
"""

import os
from collections.abc import Collection

BESIDE = ("trajectory", "replanner", "bag_record")
"""Nodes outside the chain of a tick."""


def cores_of(executable: str, domain: int, allowed: Collection[int]) -> frozenset[int]:
    """Return the cores for a node; flights in neighbouring domains use different cores for their chains.

    Args:
        executable: the node.
        domain: ROS domain of the flight.
        allowed: cores this process may use.
    """
    beside = beside_chain(domain, allowed)
    return beside if executable in BESIDE else frozenset(allowed) - beside or beside


def beside_chain(domain: int, allowed: Collection[int]) -> frozenset[int]:
    """Return the cores without the chain of a tick; the only core if there is one."""
    cores = sorted(allowed)
    return frozenset(cores) - {cores[domain % len(cores)]} or frozenset(cores)


def allowed_cores() -> frozenset[int]:
    """Return the cores this process may use."""
    return frozenset(os.sched_getaffinity(0))
