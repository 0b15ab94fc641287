"""Two hosts: network namespaces with a wire between them. Skipped where none can be made."""

import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest

ADDRESS = "10.77.7.1"
"""Address of the room."""
ROOM, DESK = f"q2q-r{os.getpid()}", f"q2q-d{os.getpid()}"
"""The hosts, and their ends of the wire."""


def run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True)


@pytest.fixture
def hosts() -> Iterator[None]:
    """Make two namespaces with a wire between them, and take them away again."""
    ends = {ROOM: f"{ADDRESS}/24", DESK: "10.77.7.2/24"}
    if shutil.which("ip") is None or os.geteuid() != 0:
        pytest.skip("network namespaces need the program ip, and root")
    try:
        for name in ends:
            run("ip", "netns", "add", name)
        wire = ["type", "veth", "peer", "name", DESK, "netns", DESK]
        run("ip", "link", "add", ROOM, "netns", ROOM, *wire)
        for name, address in ends.items():
            run("ip", "-n", name, "addr", "add", address, "dev", name)
            run("ip", "-n", name, "link", "set", name, "up")
            run("ip", "-n", name, "link", "set", "lo", "up")
            run("ip", "-n", name, "route", "add", "224.0.0.0/4", "dev", name)
        yield
    except subprocess.CalledProcessError as refused:
        pytest.skip(f"network namespaces are not permitted here: {refused.stderr.decode().strip()}")
    finally:
        for name in ends:
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)
