"""The XML report of a licence is valid whatever a program prints."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from licence_logs import LIMITS, hover

from q2q_sim.licence.flight_order import Program
from q2q_sim.licence.licence_flights import Licence
from q2q_sim.licence.licence_reports import junit_xml
from q2q_sim.licence.room.licence_log import ProgramEnd
from q2q_sim.licence.rules.licence_rules import broken_rules
from q2q_sim.licence.trial_processes import FlownTrial


def test_junit_xml_is_valid_whatever_characters_a_program_ends_with() -> None:
    """A message in a terminal's colours, half a pair of UTF-16 (of bytes that are not UTF-8), a bell."""
    error = 'RuntimeError: \x1b[31mno "vehicle" < 2\x1b[0m \udcff\ufffe\x07 \U0001f681'
    log = replace(hover(), end=ProgramEnd(10.0, 1, error, 3), output=error)
    (broken,) = broken_rules(log, LIMITS)
    assert error in broken.sentence
    found = Licence(Program(Path("p\x1b.py")), (FlownTrial(log.trial, (broken,), log, 1.0),), (), 1.0)
    case = ET.fromstring(junit_xml(found).encode()).find("testsuite/testcase")  # noqa: S314  our own
    assert case is not None
    failure, output = case.find("failure"), case.find("system-out")
    assert failure is not None
    assert output is not None
    assert output.text == 'RuntimeError: [31mno "vehicle" < 2[0m  \U0001f681'
    assert output.text in failure.get("message", "")
    assert output.text in (failure.text or "")
