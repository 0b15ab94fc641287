"""Choose the cores that a flight's nodes run on.

Within a tick most nodes wait for each other: simulator, mocap_filter, interference, controller, simulator.
Left to the scheduler they wander between cores, and each finds the cache of another; on one core of their own
a tick takes a quarter less. What works beside the chain (trajectory, replanner, recorder) gets all others.
"""

import os
from collections.abc import Collection

BESIDE = ("trajectory", "replanner", "bag_record")
"""Nodes that work while the chain does; every other one is a link of it."""


def cores_of(executable: str, domain: int, allowed: Collection[int]) -> frozenset[int]:
    """Return the cores for a node; flights in neighbouring domains keep their chains apart.

    Args:
        executable: the node.
        domain: ROS domain of the flight.
        allowed: cores this process may use.
    """
    beside = beside_chain(domain, allowed)
    return beside if executable in BESIDE else frozenset(allowed) - beside or beside


def beside_chain(domain: int, allowed: Collection[int]) -> frozenset[int]:
    """Return the cores that the chain of a tick does not run on; the only one, where there is one."""
    cores = sorted(allowed)
    return frozenset(cores) - {cores[domain % len(cores)]} or frozenset(cores)


def allowed_cores() -> frozenset[int]:
    """Return the cores this process may use."""
    return frozenset(os.sched_getaffinity(0))
