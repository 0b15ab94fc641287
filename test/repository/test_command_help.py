"""Every tool has help with an example, answers a wrong word with the nearest right one, and refuses at once.

At once: with the standard library alone. The tools run here in a Python that finds no other package, so that
nothing heavy can have been imported before the answer.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from fresh_checkout import ROOT

TOOLS = {
    "q2q_sim.commands.fly": "--lockstpe",
    "q2q_sim.commands.demo": "--jsno",
    "q2q_sim.commands.replay_page": "--titel",
    "q2q_sim.commands.report": "--comapre",
    "q2q_sim.commands.crtp": "--latencey",
    "q2q_sim.commands.bag_import": "--uot",
    "q2q_sim.commands.learn_air": "--jsno",
    "q2q_sim.commands.paper": "--onyl",
    "q2q_sim.commands.ablation": "--jsno",
    "q2q_sim.commands.campaign": "--jsno",
    "q2q_sim.commands.robustness": "--jsno",
    "q2q_sim.commands.endurance": "--jsno",
    "q2q_sim.commands.estimators": "--jsno",
    "q2q_sim.commands.explain": "--jsno",
    "q2q_sim.commands.licence": "--jnuit",
    "q2q_sim.commands.policies": "--jsno",
    "q2q_sim.commands.promise": "--jsno",
    "q2q_sim.commands.firmware_check": "--jsno",
    "q2q_sim.commands.node_pages": "--chekc",
    "q2q_sim.commands.secure": "--polciy",
    "q2q_sim.commands.validate": "--jsno",
    "q2q_planner.commands.plan": "--modle",
    "q2q_model.commands.identify": "--vehcile",
    "q2q_model.commands.evaluate": "--modle",
    "q2q_model.commands.scale_model": "--modle",
    "q2q_control.commands.call": "--ndoe",
    "q2q_control.commands.export_app": "--modle",
    "bench": "--jsno",
}
"""Each tool with a misspelt option of its own."""
REFUSALS = (
    ("q2q_sim.commands.fly tabel6", 1, "did you mean table6?"),
    ("q2q_sim.commands.fly none.yaml", 1, "none.yaml: cannot be read"),
    ("q2q_sim.commands.fly swarm2000", 1, "1 to 1000 vehicles"),
    ("q2q_sim.commands.fly table6 --model nosuch", 1, "paper_law"),
    ("q2q_sim.commands.fly table6 --real x", 1, "table6 and --real x: give one of them"),
    (
        "q2q_sim.commands.fly --real x --seed 3 --ignoring",
        1,
        "--real x and --seed, --ignoring: a replay takes only --model",
    ),
    ("q2q_sim.commands.fly --real x --distributed", 1, "--real x and --distributed: a replay takes only"),
    ("q2q_sim.commands.fly --real nosuch", 1, "neural_swarm"),
    ("q2q_sim.commands.fly table6 --record sttae", 2, "did you mean state?"),
    ("q2q_sim.commands.fly table6 --air room --air-without wnd", 2, "did you mean wind?"),
    (
        "q2q_sim.commands.fly table6 --distributed",
        1,
        "--distributed with --controller pid: give --controller mpc",
    ),
    ("q2q_sim.commands.crtp tabel6", 1, "did you mean table6?"),
    ("q2q_sim.commands.report none", 1, "no bag at none"),
    ("q2q_sim.commands.report . --vehicle nosuch", 1, "unknown vehicle"),
    ("q2q_sim.commands.replay_page none", 1, "no flight at none"),
    ("q2q_sim.commands.policies . --scenario tabel6", 2, "did you mean table6?"),
    ("q2q_sim.commands.policies none", 2, "no bag at none"),
    ("q2q_sim.commands.endurance --minutes 0.5", 1, "--minutes 0.5; must be in [1, 60] min"),
    ("q2q_sim.commands.endurance --minutes 61", 1, "--minutes 61; must be in [1, 60] min"),
    ("q2q_sim.commands.endurance --minutes 1e9", 1, "must be in [1, 60] min"),
    ("q2q_sim.commands.endurance --vehicles 1001", 2, "must be an integer in [1, 1000]"),
    ("q2q_sim.commands.endurance --minutes inf", 2, "must be a finite number"),
    ("q2q_sim.commands.estimators none", 1, "no flight at none"),
    ("q2q_sim.commands.estimators . --draws 0", 2, "0; must be an integer >= 1"),
    ("q2q_sim.commands.explain none", 1, "no bag at none"),
    ("q2q_sim.commands.explain", 2, "either a bag or --score N"),
    ("q2q_sim.commands.explain . --orders 5", 1, "5; must be even and at least 4"),
    ("q2q_sim.commands.licence none.py", 2, "no program at none.py"),
    ("q2q_sim.commands.licence", 2, "either a program or --score FOLDER"),
    ("q2q_sim.commands.licence docs", 2, "docs is a folder without __main__.py: give a program, or --score"),
    ("q2q_sim.commands.licence . --room 0 1 1", 2, "sizes must be above 0 m"),
    ("q2q_sim.commands.licence . --room nan 6 2.5", 2, "sizes must be above 0 m"),
    ("q2q_sim.commands.licence . --start 0 nan 0", 2, "nan; must be a finite number"),
    ("q2q_sim.commands.licence . --only x", 2, "--only needs --score"),
    ("q2q_sim.commands.licence --score . --air ring", 2, "--air applies to one program"),
    ("q2q_sim.commands.licence --score . --start 0 0 0", 2, "--start applies to one program"),
    ("q2q_sim.commands.promise --tube none", 1, "no tube at none"),
    ("q2q_sim.commands.promise --count 0", 2, "0; must be an integer >= 1"),
    ("q2q_sim.commands.firmware_check none", 2, "no table at none/controllers.csv"),
    ("q2q_sim.commands.bag_import none.csv --out x", 1, "no flight at none.csv"),
    ("q2q_sim.commands.validate none --air measured", 1, "no flight at none"),
    ("q2q_sim.commands.validate . --air nosuch", 1, "no air 'nosuch'"),
    ("q2q_sim.commands.validate . --air measured --draws 1", 2, "1; must be an integer in [3, 200]"),
    ("q2q_sim.commands.learn_air none --out x", 1, "no flight at none"),
    ("q2q_sim.commands.campaign --runs 1 --through-nodes 2", 2, "2; must be at most --runs 1"),
    ("q2q_sim.commands.campaign --case README.md --json x", 2, "--json has no effect with --case"),
    ("q2q_sim.commands.campaign --case README.md --air=ring", 2, "--air has no effect with --case"),
    ("q2q_sim.commands.campaign --case README.md --runs 1", 2, "--runs has no effect with --case"),
    ("q2q_sim.commands.campaign --case README.md --guided", 2, "--guided has no effect with --case"),
    ("q2q_planner.commands.plan none.yaml --out x", 1, "no waypoint file at none.yaml"),
    ("q2q_planner.commands.plan README.md --out x --warm-start none", 1, "no plan at none"),
    ("q2q_model.commands.identify none --out x", 1, "no bag at none"),
    ("q2q_model.commands.identify bags --out x --topics none", 1, "no topic map at none"),
    ("q2q_model.commands.identify --out x", 2, "give either bags of recorded flights, or --live; see"),
    ("q2q_model.commands.evaluate none --model none", 1, "no bag at none"),
    ("q2q_model.commands.evaluate bags --model none --topics none", 1, "no topic map at none"),
    ("q2q_model.commands.scale_model --model nosuch --mass 1 --rotor-radius 1 --out x", 1, "paper_law"),
    (
        "q2q_model.commands.scale_model --model none --mass 1 --rotor-radius 1 --out x --below-mass 1",
        2,
        "--below-rotor-radius together",
    ),
    ("q2q_control.commands.export_app --model nosuch --out x", 1, "measured_law"),
    ("bench smulation", 2, "did you mean simulation?"),
    (
        "bench --json planning",
        2,
        "`--json planning` names a file: give the area first, as in `bench planning",
    ),
    ("bench --baseline none", 2, "no scripts/bench in none"),
)
SCRIPTS = ("bench", "campaign", "check", "demo", "fly", "licence", "node_pages", "paper", "setup", "site")


def run(tool: str, *words: str) -> subprocess.CompletedProcess[str]:
    folders = [str(ROOT / "benchmarks"), *map(str, (ROOT / "src").glob("q2q_*"))]
    program = (
        f"import sys; sys.path[:0] = {folders}; import {tool} as tool; sys.exit(tool.main(sys.argv[1:]))"
    )
    command = [sys.executable, "-I", "-S", "-c", program, *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)


OF_NODES = {"node_command_line", "node_start"}
"""Files of the command lines of nodes, which test_node_command_line holds."""


def test_every_tool_is_held_to_this():
    found = {
        f"{path.parts[-3]}.commands.{path.stem}"
        for path in (ROOT / "src").glob("*/q2q*/*/*.py")
        if "CommandLine(" in path.read_text(encoding="utf-8") and path.stem not in {"command_line", *OF_NODES}
    }
    assert found | {"bench"} == set(TOOLS)


def test_no_tool_parses_its_words_any_other_way():
    others = [
        path
        for folder in ("src", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
        if "ArgumentParser(" in path.read_text(encoding="utf-8") and "test" not in path.parts
    ]
    assert others == []


@pytest.mark.parametrize("tool", TOOLS)
def test_help_has_an_example_and_a_wrong_word_an_answer(tool: str):
    output = run(tool, "--help")
    assert output.returncode == 0, output.stderr
    assert "example:\n  " in output.stdout
    wrong = run(tool, "x", "--out", "y", TOOLS[tool])
    assert wrong.returncode == 2
    assert any(words in wrong.stderr for words in ("did you mean --", "required", "invalid choice"))
    assert wrong.stderr.count("\n") == 1


@pytest.mark.parametrize(("words", "status", "says"), REFUSALS)
def test_what_cannot_be_done_is_refused_in_one_line(words: str, status: int, says: str):
    refused = run(*words.split())
    assert refused.returncode == status, refused.stderr
    assert says in refused.stderr
    assert refused.stderr.count("\n") == 1


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_scripts_help_sets_nothing_up(script: str):
    clean = {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": "/nowhere"}
    output = subprocess.run(
        ["bash", "-x", ROOT / "scripts" / script, "--help"],
        env=clean,
        capture_output=True,
        text=True,
        check=False,
    )
    assert output.returncode == 0, output.stderr
    assert "example:\n  " in output.stdout
    assert "+ nothing_to_do" not in output.stderr
    assert "scripts/setup --dev" not in output.stderr


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_an_interrupt_during_a_nodes_import_ends_it_without_a_word(number: str, tmp_path: Path):
    (tmp_path / "slow_node.py").write_text(
        f"import os, signal\ntry: os.kill(os.getpid(), signal.{number})\nexcept BaseException: pass\n"
        "def main(): raise SystemExit(9)\n"
    )
    folders = [str(tmp_path), str(ROOT / "src/q2q_model")]
    program = (
        f"import sys; sys.path[:0] = {folders}\n"
        "from q2q_model.commands.node_start import start_node; start_node('slow_node')"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_an_interrupt_during_a_tools_import_ends_it_with_130():
    program = (
        f"import os, signal, sys; sys.path.insert(0, {str(ROOT / 'src/q2q_model')!r})\n"
        "from q2q_model.commands.command_line import CommandLine, run_command\n"
        "def prepare(asked): os.kill(os.getpid(), signal.SIGINT); return lambda asked: 9\n"
        "sys.exit(run_command(CommandLine('tool', '', ''), prepare, []))"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (130, b"")


@pytest.mark.parametrize("package", ["numba.core", "llvmlite.binding", "logging"])
def test_an_interrupt_while_a_kernel_is_loaded_or_a_process_forks_ends_a_tool_after_it(package: str):
    inside = "import os, signal\ndef act(): os.kill(os.getpid(), signal.SIGINT); print('done')"
    program = (
        f"import signal, sys; sys.path.insert(0, {str(ROOT / 'src/q2q_model')!r})\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background ignores it
        "from q2q_model.commands.command_line import CommandLine, run_command\n"
        f"exec({inside!r}, package := {{'__name__': {package!r}}})\n"
        "def work(asked):\n    package['act']()\n    signal.pause()\n    return 9\n"
        "sys.exit(run_command(CommandLine('tool', '', ''), lambda asked: work, []))"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, b"done\n", b"tool: interrupted\n")
