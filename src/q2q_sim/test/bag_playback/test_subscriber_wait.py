"""A playback begins when its readers are matched, or after a while without them."""

from q2q_sim.bag_playback.subscriber_wait import SubscriberWait


def begun(wait: SubscriberWait, *looks: tuple[float, int, int]) -> list[bool]:
    """Return at which times [s] the wait is over, from the matches of two topics."""
    return [wait.update(now, {"/mocap": mocap, "/state": state}) for now, mocap, state in looks]


def test_a_playback_begins_half_a_second_after_the_last_match() -> None:
    wait = SubscriberWait(10.0)
    looks = (10.4, 1, 0), (11.4, 1, 1), (11.8, 2, 1), (12.25, 2, 1), (12.3, 2, 1)
    assert begun(wait, *looks) == [False] * 4 + [True]
    assert wait.note() == "begins"


def test_matches_at_the_first_look_are_waited_for_too() -> None:
    assert begun(SubscriberWait(10.0), (10.0625, 1, 1), (10.5, 1, 1), (10.5625, 1, 1)) == [False, False, True]


def test_a_topic_that_nobody_reads_is_waited_for_four_seconds() -> None:
    wait = SubscriberWait(10.0)
    assert begun(wait, (10.05, 1, 0), (13.95, 1, 0), (14.0, 1, 0)) == [False, False, True]
    assert wait.note() == "starts: after 4 s no node is connected on /state"
