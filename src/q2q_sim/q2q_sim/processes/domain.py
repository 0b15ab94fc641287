"""ROS domain of a flight, which no other flight on this machine has."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from socket import socket

from q2q_model.node.exclusive_use import claim
from q2q_model.node.loopback import DOMAIN, RANGE, chosen_domain, restrict

DOMAINS = range(20, 100)
"""Candidate domains: below 101, above those usually set by hand (ROS 2 documentation, domain id)."""

_OWN: set[int] = set()
"""Domains of this process: a campaign keeps one for all its flights."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Reserve a free domain on this machine and set ROS_DOMAIN_ID; a domain or range set by the user is kept.

    The domain is for flights of this process: to a process that it starts, the variable is one that the user
    has set, and its flights are refused as those of others in this domain.

    Raises:
        ValueError: other flights have the domain of the user, or all; or the user's is the last one, on this
            machine only; or there is no such domain.
    """
    os.environ.setdefault(RANGE, "LOCALHOST")
    restrict(os.environ)
    given = chosen_domain(os.environ)
    if given in _OWN:
        yield given
        return
    domain, claimed = _first_free(DOMAINS if given is None else [given])
    os.environ[DOMAIN] = str(domain)
    _OWN.add(domain)
    with claimed:
        try:
            yield domain
        finally:
            _OWN.remove(domain)
            if given is None:
                os.environ.pop(DOMAIN, None)


def _first_free(domains: Sequence[int]) -> tuple[int, socket]:
    """Return the first of some domains that no flight has, with its claim; raise ValueError for none."""
    for domain in domains:
        with suppress(ValueError):
            return domain, claim(f"ROS domain {domain}")
    if len(domains) == 1:
        used = f"ROS domain {domains[0]} is in use by another flight on this machine: end it"
    else:
        used = (
            f"ROS domains {domains[0]} to {domains[-1]} are in use by other flights on this machine: end one"
        )
    raise ValueError(f"{used}, or set another {DOMAIN}")
