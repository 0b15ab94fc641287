"""Vehicles, targets and plans that leave the room of a licence are reported."""

from dataclasses import replace

import pytest
from licence_logs import LIMITS, command, hover

from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.rules.licence_rules import broken_rules


@pytest.mark.parametrize(("axis", "wall"), [(0, 3.0), (0, -3.0), (1, 2.2), (1, -2.2), (2, 2.5), (2, -0.15)])
def test_a_vehicle_leaves_the_room_through_each_wall_the_ceiling_and_the_floor(
    axis: int, wall: float
) -> None:
    log = hover()
    log.pos[400:600, 0, axis] = wall * 1.01
    assert [one.rule for one in broken_rules(log, LIMITS)] == ["room"]
    log.pos[400:600, 0, axis] = wall * 0.99
    assert broken_rules(log, LIMITS) == ()


def test_a_target_outside_the_room_is_reported_when_it_is_asked_for() -> None:
    far = command(3.0, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, 60.0))
    log = hover()
    log.pos[700:, 0, 2] = 3.0
    found = broken_rules(replace(log, commands=(*log.commands, far)), LIMITS)
    assert (found[0].rule, found[0].t) == ("room", 3.0)


@pytest.mark.parametrize(
    ("low", "high"), [((0.0, 0.0, -0.7), (0.0, 0.0, 0.5)), ((0.0,) * 3, (0.0, 3.1, 1.0))]
)
def test_a_plan_that_leads_out_of_the_room_is_reported_though_nobody_flies_it_to_its_end(
    low: tuple[float, ...], high: tuple[float, ...]
) -> None:
    out = command(3.0, CommandKind.PLAN, "spiral", extent=(low, high))
    back = command(3.5, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, 1.0))
    (found,) = broken_rules(replace(hover(), commands=(out, back)), LIMITS)
    assert (found.rule, found.t, found.why) == ("room", 3.0, "spiral, line 7")


@pytest.mark.parametrize(("height", "rules"), [(-0.7, ["room"]), (-0.1, [])])
def test_a_target_below_the_floor_is_reported_unless_it_only_presses_a_landing(
    height: float, rules: list[str]
) -> None:
    below = command(3.0, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, height))
    found = broken_rules(replace(hover(), commands=(below,)), LIMITS)
    assert [one.rule for one in found] == rules
