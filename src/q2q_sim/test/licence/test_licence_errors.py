"""An error of the simulator is that of one flight: it is reported as such, and the other flights go on."""

from dataclasses import replace
from html import unescape
from math import inf
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from q2q_sim.licence.flight_order import FlightOrder, Program
from q2q_sim.licence.licence_flights import Licence, licence
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.licence_reports import (
    junit_xml,
    licence_json,
    report_text,
    verdict_text,
    write_licence_page,
)
from q2q_sim.licence.licence_score import LicenceScore, ScoredProgram, licence_score_json
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.rules.broken_rule import BrokenRule
from q2q_sim.licence.trial_processes import FlownTrial, fly_trials

WAITING = "import time\ntime.sleep(0.1)\n"
FAILING_ROOM = """
import time
from q2q_sim.loop.room import Room

def fail(*_):
    raise LookupError("no row")

Room.fly = fail
try:
    time.sleep(1.0)
except Exception:
    pass
"""
NO_ROW = "the simulator failed, not the program: LookupError: no row"
GAP = LicenceTrial(TrialKind.GAP)


def program(folder: Path, name: str, text: str) -> Program:
    """Return a program of that text."""
    file = folder / name
    file.write_text(text)
    return Program(file, (), folder)


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> tuple[FlownTrial, FlownTrial]:
    """Return a flight in which the simulator fails, and one after it in which it does not."""
    folder = tmp_path_factory.mktemp("programs")
    sound = program(folder, "sound.py", WAITING)
    order = FlightOrder(sound, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    bad = replace(order, program=program(folder, "bad.py", FAILING_ROOM), trial=GAP)
    failed, flew = fly_trials([bad, order], LicenceOptions(jobs=1), until=inf)
    return failed, flew


def test_the_flight_has_the_error_though_the_program_catches_it_and_the_next_one_is_flown(
    flights: tuple[FlownTrial, FlownTrial],
) -> None:
    failed, flew = flights
    assert failed.error is not None
    assert failed.error.trace.startswith("Traceback")
    assert (failed.error.sentence, failed.findings, failed.passed) == (NO_ROW, (), False)
    assert (flew.error, flew.passed) == (None, True)


def test_it_is_named_in_text_xml_json_and_page(
    flights: tuple[FlownTrial, FlownTrial], tmp_path: Path
) -> None:
    failed, flew = flights
    found = Licence(Program(Path("sound.py")), (flew, failed), (), 1.0)
    assert failed.error is not None
    text = report_text(found).splitlines()
    assert text[:3] == ["pass  nominal", f"ERROR  {GAP.words}", f"      {NO_ROW}"]
    assert text[-1] == f"ERROR sound.py: 1 of 2 flights; {GAP.words}: {NO_ROW}"
    suite = ET.fromstring(junit_xml(found).encode()).find("testsuite")  # noqa: S314  our own
    assert suite is not None
    assert [suite.get(one) for one in ("tests", "failures", "errors", "skipped")] == ["2", "0", "1", "0"]
    error = suite.find(f"testcase[@name='{GAP.words}']/error")
    assert error is not None
    assert (error.get("message"), error.text) == (NO_ROW, failed.error.trace)
    assert f"'error': {failed.error.trace!r}" in str(licence_json(found))
    page = write_licence_page(found, tmp_path).read_text(encoding="utf-8")
    assert page.count(NO_ROW) == 2  # verdict and row


def test_a_flight_without_time_is_a_failure_in_xml(flights: tuple[FlownTrial, FlownTrial]) -> None:
    _, flew = flights
    found = Licence(Program(Path("sound.py")), (flew,), (GAP,), 1.0)
    suite = ET.fromstring(junit_xml(found).encode()).find("testsuite")  # noqa: S314  our own
    assert suite is not None
    assert [suite.get(one) for one in ("tests", "failures", "errors", "skipped")] == ["2", "1", "0", "0"]
    failure = suite.find(f"testcase[@name='{GAP.words}']/failure")
    assert failure is not None
    assert failure.attrib == {"type": "time", "message": "no time left"}


def test_what_is_no_unicode_is_escaped_in_all_that_is_kept_of_a_program(tmp_path: Path) -> None:
    """Half a pair of UTF-16, which Python makes of the name of a file that is not UTF-8."""
    text = r"name = 'caf\udce9'; print(name); raise RuntimeError(name)"
    failing = program(tmp_path, "caf\udce9.py", text)
    order = FlightOrder(failing, LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert flight.log is not None
    assert flight.log.output == r"caf\udce9"
    assert flight.failures[0].why == r"RuntimeError: caf\udce9, line 1"
    found = Licence(failing, (flight,), (), 1.0)
    verdict = rf"FAIL caf\udce9.py: 1 of 1 flights; nominal: {flight.failures[0].sentence}"
    assert report_text(found).splitlines()[-1] == verdict
    assert licence_json(found)["program"] == r"caf\udce9.py"
    assert r' classname="caf\udce9" ' in junit_xml(found)
    assert verdict in unescape(write_licence_page(found, tmp_path).read_text(encoding="utf-8"))


def test_the_page_of_a_program_that_opens_no_vehicle_has_no_replay(
    flights: tuple[FlownTrial, FlownTrial], tmp_path: Path
) -> None:
    _, grounded = flights
    found = Licence(Program(Path("sound.py")), (grounded,), (), 1.0)
    page = write_licence_page(found, tmp_path).read_text(encoding="utf-8")
    assert "PASS sound.py" in page
    assert "<q2q-replay>" not in page


def test_a_program_is_judged_by_a_broken_rule_though_the_simulator_failed_in_another_flight(
    flights: tuple[FlownTrial, FlownTrial],
) -> None:
    failed, flew = flights
    broken = replace(flew, findings=(BrokenRule("landing", 1.0, "cf1 hits the floor"),))
    one, other = (Licence(Program(Path("p.py")), (flew, failed, *more), (), 1.0) for more in ((), (broken,)))
    assert (one.passed, one.failed, one.judged) == (False, (), False)
    assert (other.passed, other.failed, other.judged) == (False, (broken,), True)
    assert verdict_text(other).startswith("FAIL p.py: 1 of 3 flights")


def test_a_score_counts_a_program_that_could_not_be_judged_as_neither_right_nor_found(tmp_path: Path) -> None:
    found = licence(program(tmp_path, "bad.py", FAILING_ROOM), LicenceOptions())
    assert [one.verdict for one in found.flights] == ["ERROR"]
    buggy = ScoredProgram(found.program.file, sound=False)
    one = LicenceScore(buggy, found.passed, verdict_text(found), 1, 1.0, found.judged)
    assert (one.right, one.word) == (False, "ERROR")
    counts = licence_score_json([one])
    assert (counts["seeded_bugs"], counts["seeded_found"], counts["not_judged"]) == (1, 0, 1)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_program_that_starts_a_process_is_told_that_it_cannot(tmp_path: Path, method: str) -> None:
    """Python's own words were that daemonic processes have no children."""
    text = f"""
import multiprocessing
if __name__ == "__main__":
    multiprocessing.get_context("{method}").Process(target=print).start()
"""
    order = FlightOrder(
        program(tmp_path, "two.py", text), LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0
    )
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    why = "RuntimeError: a licence cannot start processes (multiprocessing): "
    why += "the emulated vehicles are in this one; use threads, line 4"
    assert [one.why for one in flight.failures] == [why]
