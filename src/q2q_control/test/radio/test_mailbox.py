"""The mailbox of a vehicle sends on whatever a packet raises, and reports it."""

from q2q_control.radio.link.mailbox import Mailbox


def test_packets_that_raise_are_reported_once_and_the_next_are_sent() -> None:
    sent: list[str] = []
    mailbox = Mailbox("cf1")
    for _ in range(2):
        mailbox.put_once(lambda: sent.append(f"{int(float('nan'))}"))
    mailbox.put_once(lambda: sent.append({}["x"]))
    mailbox.put_once(lambda: sent.append("stop"))
    mailbox.close()  # once all are sent
    assert sent == ["stop"]
    assert [line.partition(": ")[2] for line in mailbox.log_lines()] == [
        "ValueError('cannot convert float NaN to integer') (further errors of this type are not logged)",
        "KeyError('x') (further errors of this type are not logged)",
    ]
    assert mailbox.log_lines() == []


def test_a_lost_link_is_not_reported() -> None:
    def lose() -> None:
        raise OSError("gone")

    sent: list[str] = []
    mailbox = Mailbox("cf1")
    mailbox.put_once(lose)
    mailbox.put_once(lambda: sent.append("land"))
    mailbox.close()
    assert (sent, mailbox.log_lines()) == (["land"], [])
