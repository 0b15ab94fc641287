"""A stopwatch goes by its clock, and reports the longest lap once."""

from q2q_model.diagnostics.stopwatch import Stopwatch


def test_laps_are_timed_from_the_last_start_and_the_longest_is_reported_once() -> None:
    now = [5.0]
    watch = Stopwatch(lambda: now[0])
    for lap in (0.25, 0.5, 0.125):
        watch.restart()
        now[0] += lap
        watch.lap()
    assert (watch.last, watch.longest) == (0.125, 0.5)
    assert watch.take_lap_report() == {"compute_ms": "125", "compute_max_ms": "500"}
    assert watch.take_lap_report() == {"compute_ms": "125", "compute_max_ms": "0"}


def test_seconds_grow_until_it_is_restarted() -> None:
    now = [0.0]
    watch = Stopwatch(lambda: now[0])
    now[0] = 2.0
    assert watch.seconds() == 2.0
    watch.restart()
    assert watch.seconds() == 0.0
