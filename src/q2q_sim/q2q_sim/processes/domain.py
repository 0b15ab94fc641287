"""Choice of a ROS domain that no other flight on this machine uses."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from q2q_model.node.loopback import RANGE, restrict

DOMAINS = range(20, 100)
"""Candidate domains: below 101, above those usually set by hand (ROS 2 documentation, domain id)."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Reserve a free domain on this machine and set ROS_DOMAIN_ID; a domain or range set by the user is kept.

    Raises:
        OSError: all domains are taken.
        ValueError: the domain of the user is the last one, on this machine only.
    """
    os.environ.setdefault(RANGE, "LOCALHOST")
    restrict(os.environ)
    if os.environ.get("ROS_DOMAIN_ID"):
        yield int(os.environ["ROS_DOMAIN_ID"])
        return
    for domain in DOMAINS:
        path = Path(tempfile.gettempdir()) / f"q2q-domain-{domain}.lock"
        with path.open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            os.environ["ROS_DOMAIN_ID"] = str(domain)
            try:
                yield domain
            finally:
                os.environ.pop("ROS_DOMAIN_ID", None)
            return
    raise OSError(f"all ROS domains {DOMAINS.start} to {DOMAINS.stop - 1} are in use by other flights")
