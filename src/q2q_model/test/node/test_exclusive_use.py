"""What one program of the machine has claimed no other gets, until it lets go or ends."""

import os
import subprocess
import sys

import pytest

from q2q_model.node.exclusive_use import claim

WHAT = f"link {os.getpid()}" + 200 * " long"


def test_a_claim_is_refused_to_others_until_it_is_closed() -> None:
    for _ in range(2):
        with (
            claim(WHAT),
            claim(f"{WHAT} and more"),
            pytest.raises(ValueError, match=f"^{WHAT} is in use by another node on this machine: end "),
        ):
            claim(WHAT)


def test_a_claim_ends_with_its_process() -> None:
    lines = f"from q2q_model.node.exclusive_use import claim; print(claim({WHAT!r}).fileno() > 0)"
    ended = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, check=True)
    assert ended.stdout == "True\n"
    claim(WHAT).close()
