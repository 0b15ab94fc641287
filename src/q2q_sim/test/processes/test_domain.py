"""Two flights on one machine do not receive each other's messages."""

import os
import subprocess
import sys

import pytest

from q2q_model.node.exclusive_use import claim
from q2q_model.node.loopback import restrict
from q2q_sim.processes import domain as domain_module
from q2q_sim.processes.domain import own_domain

FLY = """
from q2q_sim.processes.domain import own_domain
with own_domain() as domain:
    print(domain)
"""
"""Program that reserves a domain."""


def test_flights_at_the_same_time_get_different_domains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "")  # empty is none; what stood here is put back after
    with own_domain() as first:
        monkeypatch.setenv("ROS_DOMAIN_ID", "")
        with own_domain() as second:
            assert first != second
            assert os.environ["ROS_DOMAIN_ID"] == str(second)
    assert "ROS_DOMAIN_ID" not in os.environ


def test_a_domain_the_user_has_set_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "107")
    with own_domain() as domain:
        assert domain == 107
    assert os.environ["ROS_DOMAIN_ID"] == "107"


@pytest.mark.parametrize("given", ["abc", "-1", "233", "1.5", "010"])
def test_a_domain_that_dds_does_not_have_is_refused(given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """ROS took -1 for domain 0, 1.5 for 1 and 010 for 8; Fast DDS ended the process in 233."""
    monkeypatch.setenv("ROS_DOMAIN_ID", given)
    message = rf"^ROS_DOMAIN_ID is '{given}': give an integer in \[0, 231\]$"
    with pytest.raises(ValueError, match=message), own_domain():
        pass
    with pytest.raises(ValueError, match=message):
        restrict({"ROS_DOMAIN_ID": given})  # as a node does that leaves its machine


def test_a_second_flight_in_a_domain_the_user_has_set_is_refused_until_the_first_is_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "108")
    program = [sys.executable, "-c", FLY]
    with own_domain():
        refused = subprocess.run(program, capture_output=True, text=True, check=False)
    assert refused.stderr.splitlines()[-1] == (
        "ValueError: ROS domain 108 is in use by another flight on this machine: end it, or set another "
        "ROS_DOMAIN_ID"
    )
    assert subprocess.run(program, capture_output=True, text=True, check=True).stdout == "108\n"


def test_if_flights_have_all_domains_the_next_one_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "")
    monkeypatch.setattr(domain_module, "DOMAINS", range(120, 122))
    message = "^ROS domains 120 to 121 are in use by other flights on this machine: end one, or set another"
    with (
        claim("ROS domain 120"),
        claim("ROS domain 121"),
        pytest.raises(ValueError, match=message),
        own_domain(),
    ):
        pass


def test_a_process_that_keeps_a_domain_flies_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "")
    with own_domain() as kept:
        with own_domain() as flown:
            assert flown == kept
        assert os.environ["ROS_DOMAIN_ID"] == str(kept)
