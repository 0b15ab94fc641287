"""Grading a node's health, and letting through so many events a second."""

from q2q_model.diagnostics.health import LONGEST_REASON, Health, Level, health_report, tick_rate
from q2q_model.node.decimation import Decimation


def test_a_second_with_ticks_and_nothing_else_is_ok() -> None:
    graded = health_report(Health(ticks=100), Health(ticks=200))
    assert graded.level == Level.OK
    assert graded.summary == "100 ticks"


def test_the_rate_is_that_of_ticks_over_the_time_between_two_readings() -> None:
    before, now = Health(ticks=100), Health(ticks=150)
    assert (tick_rate(before, now, 0.5), tick_rate(now, now, 1.0), tick_rate(before, now, 0.0)) == (
        100.0,
        0,
        0,
    )


def test_a_second_without_a_tick_is_stale() -> None:
    assert health_report(Health(ticks=5), Health(ticks=5)).level == Level.STALE


def test_a_node_that_never_received_an_input_reports_which_without_a_line_in_the_log() -> None:
    graded = health_report(Health(), Health(awaited="mocap not received"))
    assert (graded.level, graded.summary, graded.trouble) == (
        Level.STALE,
        "no tick: mocap not received",
        False,
    )


def test_old_trouble_does_not_colour_a_good_second() -> None:
    before = Health(ticks=10, missed=3, refused=1, last_refusal="old")
    after = Health(ticks=20, missed=3, refused=1, last_refusal="old")
    assert health_report(before, after).level == Level.OK


def test_a_missed_tick_or_a_fallback_warns_and_a_refusal_is_an_error_with_its_reason() -> None:
    assert health_report(Health(), Health(ticks=99, missed=1)).level == Level.WARN
    assert health_report(Health(), Health(ticks=99, fallbacks=1)).level == Level.WARN
    health = Health(ticks=99)
    health.refuse("state: position has 5 numbers")
    graded = health_report(Health(), health)
    assert graded.level == Level.ERROR
    assert "5 numbers" in graded.summary


def test_of_a_reason_as_long_as_the_refused_message_the_beginning_is_reported() -> None:
    health = Health()
    health.refuse("x" * LONGEST_REASON)
    assert health.last_refusal == "x" * LONGEST_REASON
    health.refuse("model: unknown key '" + 1_000_000 * "x")
    assert health.last_refusal.startswith("model: unknown key 'xxx")
    assert health.last_refusal.endswith("x...")
    assert len(health.last_refusal) == LONGEST_REASON


def test_a_fallback_is_told_from_a_missed_tick() -> None:
    lost = health_report(Health(), Health(ticks=99, missed=1))
    fallen = health_report(Health(), Health(ticks=99, fallbacks=1, fallback="cf1: failsafe LAND"))
    both = health_report(Health(), Health(ticks=99, missed=1, fallbacks=1))
    assert [one.summary for one in (lost, fallen, both)] == [
        "missing ticks",
        "in fallback: cf1: failsafe LAND",
        "in fallback; missing ticks",
    ]


def test_a_failure_is_an_error_whatever_else_is_amiss() -> None:
    health = Health(ticks=99, fallbacks=99, failure="motors cut")
    health.refuse("state: position has 5 numbers")
    for before in (Health(), health):
        graded = health_report(before, health)
        assert (graded.level, graded.summary) == (Level.ERROR, "motors cut")


def test_decimation_lets_ten_of_a_hundred_through_in_a_second() -> None:
    due = Decimation(10.0)
    assert sum(due(tick * 0.01) for tick in range(100)) == 10


def test_decimation_at_the_tick_rate_lets_all_through_and_at_zero_none() -> None:
    every, none = Decimation(100.0), Decimation(0.0)
    assert all(every(tick * 0.01) for tick in range(1000))
    assert not any(none(tick * 0.01) for tick in range(1000))


def test_decimation_starts_anew_when_time_jumps_back() -> None:
    due = Decimation(10.0)
    assert due(100.0)
    assert due(0.0)


def test_a_second_without_a_tick_reports_which_inputs_it_waits_for() -> None:
    graded = health_report(Health(ticks=5), Health(ticks=5, missed=84, awaited="state not received"))
    assert (graded.level, graded.summary, graded.trouble) == (Level.WARN, "no tick: state not received", True)
    assert not health_report(Health(), Health(ticks=9, missed=1, awaited="state not received")).trouble
