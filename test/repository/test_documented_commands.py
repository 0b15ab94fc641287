"""Every document is followed as it stands: files written, commands and snippets run, in a clean folder.

A command must end with 0 and print no traceback. A flight that ends with 1 must be one whose verdict the
document quotes. A node must come up and end with 0 on SIGINT. What is not run here stands in ELSEWHERE, with
the reason.
"""

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from documentation import Block, blocks, command_lines, commands, documents
from fresh_checkout import ROOT
from shell_session import Answer, ShellSession
from working_folder import WorkingFolder

PAGES = "docs/nodes/"
ELSEWHERE: Mapping[str, str] = {
    "scripts/demo     #": "flown with docs/tutorials/first_flight.md",
    "scripts/demo --real": "fits and flies for half a minute; test_demo_pages, test_held_out_flights",
    "scripts/fly table6 --controller mpc --stack --live": "needs a quiet machine; see test_kernels",
    "scripts/fly out/mine.yaml --live": "needs a quiet machine; test_killed_nodes flies live",
    "scripts/test": "the tests themselves; test_inner_loop asks how they are chosen",
    "python test/mutation.py": "takes half an hour",
    "python test/flight_digests.py": "takes minutes, and compares with a checkout before a change",
    "scripts/check": "runs before the tests wherever they run (.ci/run)",
    "scripts/site": "built before the tests by .ci/run; test_site searches it",
    "scripts/setup --dev": "test_setup, in a fresh checkout",
    "scripts/bench": "takes minutes; every benchmark's rows are tested in its own package",
    "scripts/paper": "takes minutes; test_paper remakes parts",
    "ros2 run q2q_sim robustness": "takes a quarter of an hour; test_robustness_page flies a short one",
    "ros2 run q2q_sim endurance": "takes minutes to an hour; test_endurance reports made samples",
    "ros2 run q2q_sim estimators": "the reader's own flights; test_estimators replays a made one",
    "ros2 run q2q_sim explain": "takes a minute; test_recorded_setup flies a short one again",
    "scripts/licence": "the reader's own programs, and a score of minutes; test_licence flies two programs",
    "ros2 run q2q_sim promise": "takes minutes; test_promise flies fewer encounters",
    "scripts/campaign --runs": "takes hours; test_campaign flies a short one",
    "scripts/campaign --guided": "takes hours; test_guided_campaign flies one of made-up runs",
    "scripts/campaign --case": "needs a case of a guided campaign; test_guided_campaign flies one again",
    "ros2 run q2q_control radio --dry-run": "needs a Crazyradio",
    "ros2 run q2q_control radio --ros-args -p crazyflies:=": "needs a Crazyradio",
    "ros2 run q2q_control crazyswarm --ros-args": "needs Crazyswarm2's packages; test_crazyswarm_bridge",
    "ros2 run q2q_control call": "test_procedure_flights makes these calls, in simulated time",
    "ros2 launch": "needs ros2 launch; test_launch_files, where it is installed",
    "ros2 run q2q_sim bag_import FLIGHT.parquet": "the reader's own table; test_bag_import",
    "ros2 run q2q_sim bag_import cf1_03": "the reader's own logs; test_imported_logs",
    "ros2 run q2q_sim learn_air FLIGHTS...": "the reader's own flights; test_learn_air_command",
    "ros2 run q2q_model identify ROOM_BAG...": "the reader's own bags; test_identify_foreign",
    "ros2 run q2q_model evaluate --model model.q2q ROOM": "the reader's own bags; test_identify_foreign",
    "ros2 run q2q_sim report ROOM_BAG": "the reader's own bags; test_report_topics",
    "ros2 run q2q_sim bag_play --ros-args -p bag:=ROOM_BAG": "the reader's own bags; test_foreign_bags",
    "ros2 run q2q_sim policies BAG...": "the reader's own bags; test_judged_bags",
    "export ROS_DOMAIN_ID=77": "two hosts: test_two_hosts, where namespaces can be made",
    "scripts/secure": "needs a middleware with DDS security; test_access_policy",
    "export ROS_SECURITY_ENABLE": "needs a middleware with DDS security; test_access_policy",
    "ros2 run q2q_control pid --ros-args --enclave": "needs DDS security; test_access_policy",
    "ROS_SECURITY_ENCLAVE_OVERRIDE": "needs a middleware with DDS security; test_access_policy",
    "export ROS_DISCOVERY_SERVER": "two hosts: test_two_hosts",
    "export ROS_SUPER_CLIENT": "two hosts: test_two_hosts",
    "fastdds discovery": "the program comes with a sourced ROS 2 only",
    "LD_LIBRARY_PATH=": "needs the address of a second host: test_two_hosts",
}
"""What a command that is not run here begins with, and why."""
NODES = {path.stem for path in (ROOT / "docs" / "nodes").glob("*.md")} | {"stack"}
DATA = Path(os.environ.get("Q2Q_DATA", ROOT.parent / "shared" / "data"))
FIRST_DOMAIN = 140
"""ROS domain of the first worker; those that flights choose by themselves end before it."""
FOLLOWED = [path for path in documents() if PAGES not in str(path) and blocks(path)]


def name_of(document: Path) -> str:
    """Return a document's path in the checkout."""
    return str(document.relative_to(ROOT))


def is_elsewhere(line: str) -> bool:
    """Return whether a command is not run here: it is in ELSEWHERE, or reads recordings that are not here."""
    return line.startswith(tuple(ELSEWHERE)) or ("$Q2Q_DATA" in line and not DATA.is_dir())


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator["Reader"]:
    """Return a reader with a clean folder and a ROS domain of their own, which flights of theirs reserve."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    domain = FIRST_DOMAIN + int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    made = Reader(tmp_path, domain)
    yield made
    made.shell_session.close()


class Reader:
    """Someone who follows a document to the letter."""

    def __init__(self, folder: Path, domain: int) -> None:
        """Lay out a clean folder."""
        self.working_folder = WorkingFolder(folder)
        self.shell_session = ShellSession(folder, os.environ)
        self._domain = domain

    def follow(self, document: Path) -> None:
        """Do all that a document says, in its order."""
        text = " ".join(document.read_text(encoding="utf-8").split())
        for block in blocks(document):
            if block.action:
                self.working_folder.put(block)
            elif block.language == "python":
                for port in re.findall(r"udp://127\.0\.0\.1:(\d+)", block.text):
                    self.shell_session.await_port(int(port))
                (self.working_folder.folder / "snippet.py").write_text(block.text)
                look_at(self.shell_session.run("python snippet.py"), block.where, text)
            elif block.language == "shell":
                self._type(block, text)
        for name in self.shell_session.nodes:
            look_at(self.shell_session.end(name), f"{document}: {name}", text)

    def _type(self, block: Block, text: str) -> None:
        for line in command_lines(block.text):
            if is_elsewhere(line):
                continue
            node = node_of(line)
            if node:
                if node in self.shell_session.nodes:
                    look_at(self.shell_session.end(node), f"{block.where}: {node}", text)
                self.shell_session.start(node, line)
                self.shell_session.await_spinning(node)
                continue
            own = line.replace("ROS_DOMAIN_ID=42", f"ROS_DOMAIN_ID={self._domain}")  # others fly, too
            look_at(self.shell_session.run(own), f"{block.where}: {line}", text)


def node_of(line: str) -> str:
    """Return the node that a command starts; empty for any other command."""
    words = line.split()
    return words[3] if words[:2] == ["ros2", "run"] and words[3] in NODES else ""


def look_at(answer: Answer, where: str, document: str) -> None:
    """Fail where an answer is not what the document lets a reader expect."""
    action = f"{where}\n{answer.output}"
    assert "Traceback" not in answer.output, action
    if answer.status != 0:
        verdicts = [line for line in answer.output.splitlines() if line.startswith("verdict: ")]
        assert answer.status == 1, action
        assert verdicts, action
        assert all(one in document for one in verdicts), f"{action}\nthe document does not say so"


@pytest.mark.parametrize("document", FOLLOWED, ids=name_of)
def test_a_document_can_be_followed_to_the_letter(document: Path, reader: Reader) -> None:
    reader.follow(document)


def test_everything_that_is_not_run_here_is_in_a_document() -> None:
    lines = [one.text for one in commands()]
    assert [start for start in ELSEWHERE if not any(line.startswith(start) for line in lines)] == []


def test_no_command_is_flown_twice() -> None:
    flights = [
        one for one in commands() if one.text.startswith("scripts/fly ") and not is_elsewhere(one.text)
    ]
    action = {"--bag", "--json", "--list"}  # later commands need what these leave, or nothing flies
    once = [one.words for one in flights if not action & set(one.words)]
    assert len(once) == len(set(once))


def test_the_bare_command_of_a_node_page_starts_it_or_says_in_one_line_what_it_lacks(reader: Reader) -> None:
    pages = [one for one in commands() if one.document.startswith(PAGES)]
    reader.shell_session.run("source scripts/env.sh")
    for one in pages:
        assert node_of(one.text) == Path(one.document).stem
        reader.shell_session.start(node_of(one.text), one.text)
    for name in reader.shell_session.nodes:
        reader.shell_session.await_spinning(name)
    for name in reader.shell_session.nodes:
        answer = reader.shell_session.end(name)
        assert "Traceback" not in answer.output, answer.output
        refused = answer.status == 2 and len(answer.output.strip().splitlines()) == 1
        assert answer.status == 0 or refused, f"{name}\n{answer.output}"


def test_what_a_document_replaces_keeps_every_line_of_it_but_the_first() -> None:
    for block in [one for document in documents() for one in blocks(document) if one.action == "replace"]:
        lines = (ROOT / block.file).read_text().splitlines()
        first = next(k for k, line in enumerate(lines) if line.startswith(block.name))
        last = next(k for k, line in enumerate(lines[first:], first) if line.startswith("}"))
        assert set(lines[first + 1 : last]) <= set(block.text.splitlines())


def test_a_failed_command_is_noticed() -> None:
    with pytest.raises(AssertionError, match="no such file"):
        look_at(Answer(2, "no such file"), "here", "")


def test_a_flight_that_falls_must_be_reported() -> None:
    fallen = Answer(1, "table\nverdict: cf2 hit the floor at 5.6 s\n")
    look_at(fallen, "here", "it says verdict: cf2 hit the floor at 5.6 s and")
    with pytest.raises(AssertionError, match="does not say so"):
        look_at(fallen, "here", "all is well")
