"""Ticks for vehicles: whole ones only, and flown only where the procedure follows their setpoint."""

from dataclasses import dataclass, field

import pytest

from q2q_control.flight_procedure.flown_ticks import FlownTicks
from q2q_model.diagnostics.health import Health
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState

NAMES = ("cf1", "cf2")
COMMAND, SETPOINT, DRAFT, STATE = (
    synthetic_signal(kind, 0.0, NAMES) for kind in (SwarmCommand, SwarmSetpoint, Interference, SwarmState)
)


@dataclass
class _Procedure:
    """Procedure that streams setpoints, or does not."""

    streams: bool = True
    seen: list[Signal] = field(default_factory=list)

    def store_state(self, state: SwarmState) -> None:
        self.seen.append(state)

    def store_command(self, command: SwarmCommand) -> None:
        self.seen.append(command)

    def store_setpoint(self, setpoint: SwarmSetpoint) -> None:
        self.seen.append(setpoint)


def test_a_setpoint_waits_for_the_downwash_of_its_own_tick() -> None:
    health = Health()
    ticks = FlownTicks("setpoint", health, aware=True)
    ticks.procedure = _Procedure()
    assert ticks.take("reference_safe", 10, SETPOINT) is None
    assert ticks.take("interference", 20, DRAFT) is None
    whole = ticks.take("interference", 10, DRAFT)
    assert whole is not None
    assert (whole.flown, whole.command, whole.setpoint, whole.downwash) == (True, None, SETPOINT, DRAFT)
    assert health.ticks == 1


def test_a_setpoint_alone_is_a_tick_where_no_downwash_is_compensated() -> None:
    ticks = FlownTicks("setpoint", Health(), aware=False)
    ticks.procedure = _Procedure()
    whole = ticks.take("reference_safe", 10, SETPOINT)
    assert whole is not None
    assert (whole.flown, whole.setpoint, whole.downwash) == (True, SETPOINT, None)


@pytest.mark.parametrize("streams", [True, False])
def test_a_command_is_flown_while_the_procedure_streams(streams: bool) -> None:
    ticks = FlownTicks("command", Health(), aware=True)
    ticks.procedure = procedure = _Procedure(streams)
    assert ticks.take("reference_safe", 10, SETPOINT) is None
    whole = ticks.take("command", 20, COMMAND)
    assert procedure.seen == [SETPOINT, COMMAND]
    assert whole is not None
    assert (whole.flown, whole.command) == (streams, COMMAND)


@pytest.mark.parametrize(("mode", "rest"), [("setpoint", DRAFT), ("command", COMMAND)])
def test_no_tick_is_flown_that_a_landing_has_overtaken(mode: str, rest: Signal) -> None:
    """One packet after it made the vehicle ignore the landing, hover, and fall 2 s later."""
    ticks = FlownTicks(mode, Health(), aware=True)
    ticks.procedure = procedure = _Procedure()
    ticks.take("reference_safe", 10, SETPOINT)
    procedure.streams = False  # `land`, before the rest of the tick comes
    whole = ticks.take("interference" if mode == "setpoint" else "command", 10, rest)
    assert whole is not None
    assert not whole.flown


def test_states_go_to_the_procedure_and_make_no_tick() -> None:
    ticks = FlownTicks("command", Health(), aware=True)
    ticks.procedure = procedure = _Procedure()
    assert ticks.take("state", 10, STATE) is None
    assert procedure.seen == [STATE]


def test_without_a_procedure_nothing_is_flown() -> None:
    ticks = FlownTicks("setpoint", Health(), aware=False)
    ticks.take("state", 10, STATE)
    whole = ticks.take("reference_safe", 10, SETPOINT)
    assert whole is not None
    assert not whole.flown
