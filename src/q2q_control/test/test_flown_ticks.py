"""Ticks for vehicles: whole ones only, and flown only where the procedure follows their setpoint."""

from dataclasses import dataclass, field

import pytest

from q2q_control.flight_procedure.flown_ticks import FlownTicks
from q2q_model.node.health import Health
from q2q_model.node.rehearsal import rehearsal
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState

NAMES = ("cf1", "cf2")
COMMAND, SETPOINT, DRAFT, STATE = (
    rehearsal(kind, 0.0, NAMES) for kind in (SwarmCommand, SwarmSetpoint, Interference, SwarmState)
)


@dataclass
class _Procedure:
    """Procedure that follows setpoints, or none."""

    grants: bool = True
    seen: list[SwarmState] = field(default_factory=list)
    heard: list[SwarmCommand] = field(default_factory=list)

    def store_state(self, state: SwarmState) -> None:
        self.seen.append(state)

    def store_command(self, command: SwarmCommand) -> None:
        self.heard.append(command)

    def accepts(self, _: SwarmSetpoint) -> bool:
        return self.grants


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


@pytest.mark.parametrize("grants", [True, False])
def test_a_command_is_flown_where_the_last_setpoint_was_followed(grants: bool) -> None:
    ticks, procedure = FlownTicks("command", Health(), aware=True), _Procedure(grants)
    ticks.procedure = procedure
    before = ticks.take("command", 10, COMMAND)
    assert procedure.heard == [COMMAND]
    assert before is not None
    assert (before.flown, before.command) == (False, COMMAND)
    assert ticks.take("reference_safe", 10, SETPOINT) is None
    after = ticks.take("command", 20, COMMAND)
    assert after is not None
    assert after.flown is grants


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
