"""Recent ticks are found by their stamp, and forgotten after the span."""

from dataclasses import dataclass

from q2q_model.signals.recent_ticks import RecentTicks


@dataclass(frozen=True)
class Tick:
    """Tick of a time [s]."""

    t: float


def test_a_tick_is_found_by_its_stamp_until_the_span_has_passed() -> None:
    ticks: RecentTicks[Tick] = RecentTicks(0.3)
    assert ticks.last is None
    assert ticks.at(0.0) is None
    assert not ticks.is_over(0.0)
    kept = [Tick(0.1 * k) for k in range(6)]
    for tick in kept:
        ticks.remember(tick)
    assert ticks.last is kept[5]
    assert ticks.at(0.4 + 1e-7) is kept[4]
    assert ticks.at(0.45) is None
    assert ticks.at(0.1) is None  # 0.4 s ago
    assert ticks.is_over(0.45)
    assert not ticks.is_over(0.51)
    ticks.reset()
    assert ticks.last is None
