"""The page of a licence has a line for each finding, and says a reason that several share once."""

from q2q_sim.licence.rules.broken_rule import BrokenRule
from q2q_sim.licence.rules.finding_lines import finding_lines

FAILED = "the program failed (RuntimeError: boom, line 11), which closed the link"


def test_findings_of_one_reason_stand_under_it() -> None:
    """Links that a failing program closes one after the other share the reason, though not its time."""
    found = [
        BrokenRule("motors", 3.26, "the motors of cf1 stop", f"{FAILED} at 3.25 s"),
        BrokenRule("room", 3.5, "cf3 leaves the room", "go_to at 3.00 s"),
        BrokenRule("motors", 4.19, "the motors of cf2 stop", f"{FAILED} at 4.18 s"),
        BrokenRule("end", 5.0, "cf3 is in the air"),
    ]
    assert list(finding_lines(found)) == [
        f"{FAILED}:",
        "• at 3.26 s the motors of cf1 stop",
        "• at 4.19 s the motors of cf2 stop",
        "at 3.50 s cf3 leaves the room: go_to at 3.00 s",
        "at 5.00 s cf3 is in the air",
    ]


def test_a_reason_that_is_the_same_keeps_its_time() -> None:
    found = [BrokenRule("motors", 3.0, f"the motors of cf{k} stop", "stop at 2.99 s, line 7") for k in (1, 2)]
    assert next(finding_lines(found)) == "stop at 2.99 s, line 7:"


def test_remarks_are_told_apart_from_failures_of_the_same_reason() -> None:
    found = [BrokenRule("idle", 1.0, f"cf{k} stays", "the link is lost", remark=k > 1) for k in (1, 2, 3)]
    assert list(finding_lines(found)) == [
        "at 1.00 s cf1 stays: the link is lost",
        "remarks: the link is lost:",
        "• at 1.00 s cf2 stays",
        "• at 1.00 s cf3 stays",
    ]
