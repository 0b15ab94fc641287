"""Two flights on one machine do not receive each other's messages."""

import os

import pytest

from q2q_sim.processes.domain import own_domain


def test_flights_at_the_same_time_get_different_domains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "")  # empty is none; what stood here is put back after
    with own_domain() as first:
        monkeypatch.setenv("ROS_DOMAIN_ID", "")
        with own_domain() as second:
            assert first != second
            assert os.environ["ROS_DOMAIN_ID"] == str(second)
    assert "ROS_DOMAIN_ID" not in os.environ


def test_a_domain_the_user_has_set_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    with own_domain() as domain:
        assert domain == 7
