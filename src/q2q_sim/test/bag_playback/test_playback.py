"""Each message of a bag is due at its bag time, after pauses and in each round of a loop."""

from q2q_sim.bag_playback.playback import Playback


def test_a_pause_delays_what_is_due_after_it_and_a_round_begins_with_the_end_of_the_last() -> None:
    playback = Playback(first_ns=2_000_000_000, began=10.0, rate=2.0)
    assert playback.due(6_000_000_000) == 12.0
    assert playback.after_pause(5.0).due(6_000_000_000) == 17.0
    assert playback.next_round(6_000_000_000, 12.0).due(6_000_000_000) == 14.0
    assert playback.next_round(2_000_000_000, 12.0).due(2_000_000_000) == 13.0  # a bag of one moment
