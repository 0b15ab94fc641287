"""Vehicles that two controllers command are found, and those that share the vehicles are not."""

import numpy as np
from resting_signals import level_command

from q2q_model.signals.values import Names, SwarmCommand
from q2q_sim.link.conflicting_commands import RECENT, ConflictingCommands, conflict_note

NAMES = ("cf1", "cf2")
TICK_NS = 10_000_000


def command(thrust: float, names: Names = NAMES) -> SwarmCommand:
    """Return a command that differs in the thrust of its last vehicle."""
    thrusts = np.array([0.3] * (len(names) - 1) + [thrust])
    return level_command(0.0, names, thrusts)


def conflicts(*commands: tuple[int, SwarmCommand]) -> Names:
    """Return who gets conflicting commands after commands of these ticks."""
    watch = ConflictingCommands()
    for tick, one in commands:
        watch.take(tick * TICK_NS, one)
    return watch.take_conflicts()


def test_vehicles_with_two_controllers_are_named_until_one_is_gone() -> None:
    watch = ConflictingCommands()
    for tick in range(2):
        watch.take(tick * TICK_NS, command(0.3))
        watch.take(tick * TICK_NS, command(0.4))
    assert watch.take_conflicts() == ("cf2",)  # of cf1 both think the same
    watch.take(2 * TICK_NS, command(0.3))
    assert watch.take_conflicts() == ()


def test_a_controller_of_some_vehicles_beside_one_of_all_is_found_in_either_order() -> None:
    one, both = command(0.4, ("cf2",)), command(0.3)
    for first, second in ((one, both), (both, one)):
        assert conflicts((0, first), (0, second), (1, first), (1, second)) == ("cf2",)


def test_a_controller_that_answers_ticks_later_than_the_other_is_found() -> None:
    late = RECENT // 2 - 1
    ticks = [one for tick in range(99) for one in ((tick, command(0.3)), (tick - late, command(0.4)))]
    assert conflicts(*ticks) == ("cf2",)


def test_controllers_of_a_vehicle_each_and_commands_sent_again_are_right() -> None:
    shared = [(tick, command(0.1 * tick, (name,))) for tick in range(9) for name in NAMES]
    assert conflicts(*shared, *shared) == ()


def test_an_emergency_that_cuts_what_its_tick_commanded_is_one_controller() -> None:
    assert conflicts((0, command(0.3)), (1, command(0.3)), (1, command(0.0)), (2, command(0.0))) == ()


def test_vehicles_that_two_nodes_fly_are_named_with_the_nodes_unless_one_has_left() -> None:
    message = "command: two nodes fly cf2: stop one, or give each its own `vehicles` (mpc, pid write it)"
    assert conflict_note(("cf2",), ["mpc", "pid"]) == message
    assert conflict_note(("cf2",), ["pid"]) == ""


def test_the_vehicles_of_recent_commands_are_known() -> None:
    watch = ConflictingCommands()
    watch.take(0, level_command(0.0, ("cf9",), np.zeros(1)))
    for k in range(1, RECENT):
        watch.take(k, level_command(0.01 * k, ("cf2", "cf1"), np.zeros(2)))
    assert watch.commanded == ("cf1", "cf2", "cf9")
    watch.take(RECENT, level_command(0.01 * RECENT, ("cf2",), np.zeros(1)))
    assert watch.commanded == ("cf1", "cf2")
