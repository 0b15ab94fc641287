"""The share of pings that come back is the quality of a link over UDP."""

import math

import pytest

from q2q_control.radio.link.ping_share import WINDOW, PingShare


def pinged(lost: int, times: int) -> PingShare:
    """Return the count of `times` pings of which each `lost`-th gets lost; 0 is none."""
    pings = PingShare()
    for k in range(1, times + 1):
        pings.sent()
        if not (lost and k % lost == 0):
            pings.answered()
    return pings


@pytest.mark.parametrize(("lost", "share"), [(0, 1.0), (1, 0.0), (4, 0.75)])
def test_the_share_is_that_of_the_pings_that_came_back(lost: int, share: float) -> None:
    assert pinged(lost, 5 * WINDOW + 1).share == pytest.approx(share)


def test_nothing_is_reported_before_a_ping_had_time_to_come_back() -> None:
    assert math.isnan(PingShare().share)
    assert math.isnan(pinged(1, 1).share)


def test_a_link_that_dies_loses_its_quality_within_the_window() -> None:
    pings = pinged(0, WINDOW)
    for _ in range(WINDOW + 1):
        pings.sent()
    assert pings.share == 0.0


def test_an_answer_that_overtakes_the_note_of_its_ping_counts_once() -> None:
    pings = pinged(0, 3)
    pings.answered()
    pings.answered()
    for _ in range(3):
        pings.sent()
    assert pings.share == pytest.approx(4 / 5)  # the fourth came back, the fifth did not
