"""Messages of other programs do not end the tool that directs a flight."""

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rosgraph_msgs.msg import Clock

from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.flight_director import FlightDirector


def told(ticks: str) -> DiagnosticArray:
    """Return the diagnostics of some simulator with a number of ticks."""
    values = [KeyValue(key="ticks", value=ticks)]
    return DiagnosticArray(status=[DiagnosticStatus(name="/other/simulator", values=values)])


def test_ticks_that_are_no_count_and_a_clock_that_is_none_leave_the_last_ticks() -> None:
    with own_domain(), FlightDirector(lambda: None) as director:
        director._on_diagnostics(told("12"))
        for ticks in ("12.5", "", "many", "-1"):
            director._on_diagnostics(told(ticks))
        assert director.ticks == 12
        director._on_clock(Clock(clock=Time(sec=1, nanosec=2**32 - 1)))
        assert director.ticks == 12
        director._on_clock(Clock(clock=Time(sec=1, nanosec=20_000_000)))
        assert director.ticks == 102
