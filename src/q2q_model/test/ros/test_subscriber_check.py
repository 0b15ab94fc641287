"""Tests of the question whether anyone subscribes."""

from q2q_model.ros.topics.subscriber_check import SubscriberCheck


class Counted:
    """Publisher that counts how often it is asked."""

    def __init__(self) -> None:
        self.subscribers, self.asked = 0, 0

    def get_subscription_count(self) -> int:
        """Return the number of subscribers."""
        self.asked += 1
        return self.subscribers


def test_a_new_subscriber_is_seen_after_the_interval() -> None:
    one = Counted()
    check = SubscriberCheck((one,), interval_ns=100)
    assert not check.has_subscribers(0)
    one.subscribers = 1
    assert [check.has_subscribers(stamp) for stamp in (10, 50, 99, 100, 199)] == [
        False,
        False,
        False,
        True,
        True,
    ]
    assert one.asked == 2


def test_a_stamp_that_comes_again_or_is_late_asks() -> None:
    one = Counted()
    check = SubscriberCheck((one,), interval_ns=100)
    assert not check.has_subscribers(10)
    one.subscribers = 1
    assert check.has_subscribers(10)  # a frame is sent again: someone waits
    one.subscribers = 0
    assert not check.has_subscribers(5)  # the clock was set back


def test_one_subscriber_of_several_publishers_is_enough() -> None:
    first, second = Counted(), Counted()
    second.subscribers = 2
    assert SubscriberCheck((first, second)).has_subscribers(0)
    assert not SubscriberCheck(()).has_subscribers(0)
