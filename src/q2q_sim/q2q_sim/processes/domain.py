"""ROS domain of a flight, which no other flight on this machine has."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from socket import socket

from q2q_model.node.exclusive_use import claim
from q2q_model.node.loopback import DOMAIN, RANGE, restrict

DOMAINS = range(20, 100)
"""Candidate domains: below 101, above those usually set by hand (ROS 2 documentation, domain id)."""

_OWN: set[int] = set()
"""Domains of this process: one that keeps a domain for many flights flies some in processes of their own."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Reserve a free domain on this machine and set ROS_DOMAIN_ID; a domain or range set by the user is kept.

    Raises:
        ValueError: other flights have the domain of the user, or all; or the user's is the last one, on this
            machine only.
    """
    os.environ.setdefault(RANGE, "LOCALHOST")
    restrict(os.environ)
    given = os.environ.get(DOMAIN)
    if given and int(given) in _OWN:
        yield int(given)
        return
    domain, claimed = _first_free([int(given)] if given else DOMAINS)
    os.environ[DOMAIN] = given or str(domain)
    _OWN.add(domain)
    with claimed:
        try:
            yield domain
        finally:
            _OWN.remove(domain)
            if not given:
                os.environ.pop(DOMAIN, None)


def _first_free(domains: Sequence[int]) -> tuple[int, socket]:
    """Return the first of some domains that no flight has, with its claim; raise ValueError for none."""
    for domain in domains:
        with suppress(ValueError):
            return domain, claim(f"ROS domain {domain}")
    asked = f"{domains[0]}" if len(domains) == 1 else f"{domains[0]} to {domains[-1]}"
    raise ValueError(
        f"ROS domain {asked} is in use by another flight on this machine: end it, or set another {DOMAIN}"
    )
