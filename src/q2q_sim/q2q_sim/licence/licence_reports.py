"""Reports of a licence: text, JSON, JUnit XML (as pytest writes it), and a page with replay."""

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from q2q_model.counted import counted
from q2q_model.documents.json_file import Json
from q2q_model.documents.written_file import write_text
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.licence.licence_flights import Licence
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.rules.finding_lines import finding_lines
from q2q_sim.licence.trial_processes import FlownTrial
from q2q_sim.replay_page import ReplayRun, replay_element
from q2q_sim.report.html_page import Grid, Heading, Markup, PageVerdict, Part, ProgramOutput, page

FORBIDDEN = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What is no character of XML 1.0 (section 2.2)."""
HEAD = ("flight", "verdict", "what falls, when, and why")


def verdict_text(found: Licence) -> str:
    """Return the verdict in one line."""
    name, count = found.program.name, len(found.flights)
    if found.failed:
        first = found.failed[0]
        return (
            f"FAIL {name}: {len(found.failed)} of {count} flights; {first.trial.words}: "
            f"{first.failures[0].sentence}"
        )
    if found.errors:
        first = found.errors[0]
        flights = f"{len(found.errors)} of {count} flights"
        return f"ERROR {name}: {flights}; {first.trial.words}: {first.sentences[0]}"
    if found.left_out:
        return f"FAIL {name}: no time for {len(found.left_out)} of {count + len(found.left_out)} flights"
    grounded = "" if found.flew else "; no vehicle flew"
    remarks = sum(len(one.findings) for one in found.flights)
    noted = f"; {counted(remarks, 'remark')}" if remarks else ""
    return f"PASS {name}: {counted(count, 'flight')} in {found.seconds:.0f} s{grounded}{noted}"


def report_text(found: Licence) -> str:
    """Return a line for each flight, then the verdict."""
    lines = []
    for one in found.flights:
        lines.append(f"{one.verdict}  {one.trial.words}")
        trace = one.error.trace.splitlines() if one.error is not None else ()
        lines += [f"      {line}" for line in (*one.sentences, *trace)]
    lines += [f"not flown  {trial.words}" for trial in found.left_out]
    return "\n".join([*lines, verdict_text(found)])


def licence_json(found: Licence) -> Json:
    """Return a licence as plain values: the contract of `licence --json`."""
    return {
        "program": found.program.name,
        "passed": found.passed,
        "flew": found.flew,
        "verdict": verdict_text(found),
        "seconds": found.seconds,
        "flights": [
            {
                "trial": one.trial.words,
                "kind": str(one.trial.kind),
                "passed": one.passed,
                "error": "" if one.error is None else one.error.trace,
                "findings": [
                    {
                        "rule": each.rule,
                        "t_s": each.t,
                        "what": each.what,
                        "why": each.why,
                        "remark": each.remark,
                    }
                    for each in one.findings
                ],
            }
            for one in found.flights
        ],
        "not_flown": [trial.words for trial in found.left_out],
    }


def junit_xml(found: Licence) -> str:
    """Return a licence as JUnit XML, one test case for each flight."""
    suites = ET.Element("testsuites")
    suite = ET.SubElement(suites, "testsuite", name="licence", time=f"{found.seconds:.3f}")
    suite.set("tests", str(len(found.flights) + len(found.left_out)))
    suite.set("failures", str(len(found.failed) + len(found.left_out)))
    suite.set("errors", str(len(found.errors)))
    suite.set("skipped", "0")
    for one in found.flights:
        case = _case(suite, found, one.trial.words, one.seconds)
        _add_outcome(case, one)
        remarks = [each.sentence for each in one.findings if each.remark]
        output = "\n".join([*remarks, one.log.output if one.log is not None else ""]).strip()
        if output:
            ET.SubElement(case, "system-out").text = output
    for trial in found.left_out:
        ET.SubElement(_case(suite, found, trial.words, 0.0), "failure", type="time", message="no time left")
    ET.indent(suites)
    return _valid(ET.tostring(suites, encoding="unicode", xml_declaration=True)) + "\n"


def _case(suite: ET.Element, found: Licence, name: str, seconds: float) -> ET.Element:
    program = Path(found.program.name).stem
    return ET.SubElement(suite, "testcase", classname=program, name=name, time=f"{seconds:.3f}")


def _add_outcome(case: ET.Element, flight: FlownTrial) -> None:
    """Add to a test case which rules were broken, or how the simulator failed."""
    if flight.error is not None:
        error = ET.SubElement(case, "error", type="simulator", message=flight.error.sentence)
        error.text = flight.error.trace
    elif flight.failures:
        first = flight.failures[0]
        failure = ET.SubElement(case, "failure", type=first.rule, message=first.sentence)
        failure.text = "\n".join(each.sentence for each in flight.failures)


def _valid(text: str) -> str:
    """Return a document without the characters that XML 1.0 forbids, as terminals' colours begin with."""
    return FORBIDDEN.sub("", text)


def write_licence_page(found: Licence, folder: Path) -> Path:
    """Write the page of a licence into a folder; return its path."""
    rows = [(one.trial.words, one.verdict, _found_text(one)) for one in found.flights]
    rows += [(trial.words, "not flown", "no time left") for trial in found.left_out]
    parts: list[Part] = [PageVerdict(verdict_text(found), ok=found.passed), Grid(HEAD, rows)]
    shown = [found.flights[0], *(one for one in found.failed[:1] if one is not found.flights[0])]
    runs = [_run(one, one.log) for one in shown if one.log is not None and one.log.uris]
    if runs:
        parts += [Heading(" and ".join(run.name for run in runs)), Markup(replay_element(runs))]
    output = shown[-1].log.output if shown[-1].log is not None else ""
    if output:
        parts += [Heading("Last lines of the program's output"), ProgramOutput(output)]
    file = folder / "index.html"
    write_text(page(f"Licence of {found.program.name}", _lead(found), parts), file)
    return file


def _found_text(flight: FlownTrial) -> str:
    """Return the lines of what was found, or how the simulator failed."""
    errors = () if flight.error is None else (flight.error.sentence,)
    return "\n".join((*errors, *finding_lines(flight.findings))) or "-"


def _lead(found: Licence) -> str:
    if found.passed and not found.flew:
        return "The program ran unmodified with emulated vehicles, none of which left the floor."
    flew = "The program flew emulated vehicles unmodified"
    if len(found.flights) == 1 and found.errors:
        return f"{flew}, without faults. The simulator failed, so it did not fly with faults."
    if len(found.flights) == 1 and not found.flights[0].passed:
        return f"{flew}, without faults. It failed, so it did not fly with faults."
    return f"{flew}, first without faults, then with one fault each."


def _run(flown: FlownTrial, log: LicenceLog) -> ReplayRun:
    unknown = np.full_like(log.pos, np.nan)
    return ReplayRun(
        name=flown.trial.words,
        names=tuple(log.name(row) for row in range(len(log.uris))),
        t=log.t,
        pos=log.pos,
        quat=log.quat,
        ref_pos=unknown,
        mocap_pos=unknown,
        rejected=np.zeros(log.thrust.shape, dtype=np.bool_),
        downwash=unknown,
        thrust=log.thrust,
        arm=CRAZYFLIE_2_0.arm,
        verdict=flown.failures[0].sentence if flown.failures else "pass",
    )
