"""The layout of the packages: ideas are found by folder and file name, and names are unique."""

import ast
import subprocess
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from fresh_checkout import ROOT
from mutated_modules import MUTATED

PACKAGES = sorted(path.parent for path in ROOT.glob("src/*/*/__init__.py"))
MODULES = sorted(path for package in PACKAGES for path in package.rglob("*.py"))
SHELLS = {"ros", "commands", "tools"}
"""Folders of the entry points: a file for each node, command or tool."""
ROOT_FILES = {
    ".dockerignore",
    ".gitignore",
    ".pre-commit-config.yaml",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Dockerfile",
    "LICENSE",
    "README.md",
    "colcon.meta",
    "conftest.py",
    "pyproject.toml",
}
"""Files at the root of the repository: what a tool looks for there, and a reader. Others have a folder."""
MOST_ENTRIES = 14
"""Modules and folders in one folder of the library. Eight is the aim."""
MOST_LINES = 40
"""Lines of a function without its docstring."""
QUESTIONS = (
    ("where is the outlier gate?", "q2q_model/estimation/position/position_gates.py", "PositionGates"),
    ("where is the mocap filter?", "q2q_model/estimation/mocap_filter.py", "MocapFilter"),
    ("where is the jet law?", "q2q_model/downwash/jet.py", "Jet"),
    ("what is an interaction model?", "q2q_model/downwash/interaction_model.py", "InteractionModel"),
    ("where are the vehicle constants?", "q2q_model/vehicle/constants.py", "Vehicle"),
    ("where is thrust per PWM?", "q2q_model/vehicle/thrust_map.py", "motor_thrust"),
    ("where is a bag written?", "q2q_model/bag/writer.py", "BagWriter"),
    ("where are polynomial trajectories evaluated?", "q2q_model/trajectory/polynomials.py", "setpoint_at"),
    (
        "where are gains identified from commands?",
        "q2q_model/identification/gains/command_gains.py",
        "gains_from_commands",
    ),
    ("where are inputs joined by stamp?", "q2q_model/signals/tick_join.py", "TickJoin"),
    (
        "where is minimum snap solved?",
        "q2q_planner/offline/minimum_snap/minimum_snap.py",
        "minimum_snap",
    ),
    ("where is a plan certified?", "q2q_planner/offline/certificate/certificate.py", "certify"),
    ("where is the potential field?", "q2q_planner/online/potential_field.py", "PotentialField"),
    ("which replanner has a guarantee?", "q2q_planner/online/safe/safe_replanner.py", "SafeReplanner"),
    ("where is the PID?", "q2q_control/pid/pid.py", "Pid"),
    ("where is a command clipped?", "q2q_control/attitude/thrust_vector.py", "write_command"),
    ("where is the Riccati recursion?", "q2q_control/mpc/solver/riccati.py", "solve"),
    ("where are the fallback phases?", "q2q_control/failsafe/fallback_phases.py", "fallback_command"),
    ("where is a real vehicle's radio link?", "q2q_control/radio/link/cflib_link.py", "CflibLink"),
    (
        "where is the firmware's supervisor emulated?",
        "q2q_sim/firmware/supervisor/supervisor.py",
        "Supervisor",
    ),
    ("where are the motors' constants?", "q2q_sim/firmware/motors/thrust_curve.py", "CURVE"),
    ("where is motion capture simulated?", "q2q_sim/sensors/vicon.py", "Vicon"),
    ("which faults are there?", "q2q_sim/faults/faults.py", "Fault"),
    ("where is the closed loop?", "q2q_sim/loop/closed_loop.py", "fly"),
    ("where are the safety policies' limits?", "q2q_sim/monitors/policies/inputs/limits.py", "Limits"),
)
"""Question, file under src/PACKAGE, and the public class, function or constant that answers it."""
MIXED_TUPLES = {
    "q2q_control/q2q_control/mpc/limited_command.py:write_commands(tick)",
    "q2q_control/q2q_control/pid/pid_kernel.py:pid_commands(tick)",
    "q2q_model/q2q_model/estimation/nominal_frame.py:nominal_frame(memory)",
    "q2q_sim/q2q_sim/link/radio_kernel.py:send_packets(chance)",
    "q2q_sim/q2q_sim/link/radio_kernel.py:send_packets(commands)",
    "q2q_sim/q2q_sim/link/radio_kernel.py:send_packets(flying)",
    "q2q_sim/q2q_sim/link/radio_kernel.py:send_packets(sent)",
    "q2q_sim/q2q_sim/plant/swarm.py:run_in_law(air)",
    "q2q_sim/q2q_sim/plant/swarm.py:run_in_law(body)",
    "q2q_sim/q2q_sim/plant/swarm.py:write_wake_law_push(air)",
    "q2q_model/q2q_model/bag/storage/indexed_mcap.py:_count_before(waiting)",
}
"""Parameters whose types are tuples of several types by an alias. Those of kernels are faster than named ones
where Python calls; messages of a bag are sorted as tuples."""


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a module."""
    return ast.parse(path.read_text(encoding="utf-8"))


def public_classes(path: Path) -> list[str]:
    """Return the public classes of a module."""
    classes = [node.name for node in parsed(path).body if isinstance(node, ast.ClassDef)]
    return [name for name in classes if not name.startswith("_")]


def names(path: Path) -> set[str]:
    """Return the classes, functions and constants that a module defines."""
    body = parsed(path).body
    defined = {node.name for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    targets = [one for node in body if isinstance(node, ast.Assign) for one in node.targets]
    return defined | {one.id for one in targets if isinstance(one, ast.Name)}


def functions() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield every function of the packages, with its module and name."""
    for path in MODULES:
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.FunctionDef):
                yield f"{path.relative_to(ROOT / 'src')}:{node.name}", node


def length(function: ast.FunctionDef) -> int:
    """Return the lines of a function without its docstring."""
    return lines(function) - (lines(function.body[0]) if ast.get_docstring(function) else 0)


def lines(node: ast.stmt) -> int:
    """Return the lines of a statement."""
    return (node.end_lineno or node.lineno) - node.lineno + 1


def is_mixed(annotation: ast.expr, path: Path | None = None) -> bool:
    """Return whether a type contains a tuple of three or more elements of several types.

    Names that the module at `path` gives to types, or imports, are resolved. A name for the fields of a named
    tuple beside it, which says what they are, counts as one type.
    """
    for node in ast.walk(annotation):
        if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "tuple":
            parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            kinds = [ast.unparse(part) for part in parts]
            if "..." not in kinds and len(kinds) > 2 and len(set(kinds)) > 1:
                return True
        named = aliased(node.id, path) if path and isinstance(node, ast.Name) else None
        if named and not is_of_fields(*named) and is_mixed(*named):
            return True
    return False


def is_of_fields(alias: ast.expr, path: Path) -> bool:
    """Return whether a type is the tuple of the fields of a named tuple of its module."""
    classes = [node for node in parsed(path).body if isinstance(node, ast.ClassDef)]
    named = [one for one in classes if "NamedTuple" in map(ast.unparse, one.bases)]
    fields = [[node.annotation for node in one.body if isinstance(node, ast.AnnAssign)] for one in named]
    return ast.unparse(alias) in {f"tuple[{', '.join(map(ast.unparse, one))}]" for one in fields}


@cache
def aliased(name: str, path: Path) -> tuple[ast.expr, Path] | None:
    """Return the type that a module gives or imports by a name, and the module that gives it."""
    for node in parsed(path).body:
        if isinstance(node, ast.ImportFrom) and (source := module_path(node.module or "")):
            for one in node.names:
                if name == (one.asname or one.name):
                    return aliased(one.name, source)
        elif isinstance(node, ast.Assign) and name in {ast.unparse(one) for one in node.targets}:
            return node.value, path
    return None


@cache
def module_path(name: str) -> Path | None:
    """Return the file of a module of the packages."""
    stem = ROOT.joinpath("src", name.partition(".")[0], *name.split("."))
    return next((one for one in (stem.with_suffix(".py"), stem / "__init__.py") if one.is_file()), None)


def repeated(found: list[str]) -> list[str]:
    """Return the strings that occur more than once."""
    return sorted(name for name, count in Counter(found).items() if count > 1)


@pytest.mark.parametrize(("question", "file", "name"), QUESTIONS, ids=[one[0] for one in QUESTIONS])
def test_a_question_is_answered_by_folder_and_file_name(question: str, file: str, name: str):
    path = ROOT / "src" / file.partition("/")[0] / file
    assert path.is_file(), question
    assert name in names(path), question


def test_no_file_lies_at_the_root_of_the_repository_that_does_not_belong_there() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("no repository: what lies here is not what is committed")
    committed = subprocess.run(
        ["git", "ls-files", "--", ":(glob)*"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert set(committed.stdout.split()) == ROOT_FILES


def test_no_two_modules_share_a_name():
    assert repeated([path.stem for path in MODULES if path.stem != "__init__"]) == []


def test_no_two_public_classes_share_a_name():
    assert repeated([name for path in MODULES for name in public_classes(path)]) == []


def test_modules_that_are_mutated_and_their_tests_are_where_they_are_said_to_be():
    modules = {name for one in MUTATED for name in one.modules}
    found = {".".join(path.relative_to(ROOT / "src").with_suffix("").parts[1:]) for path in MODULES}
    assert modules - found == set()
    assert [name for one in MUTATED for name in one.tests if not (ROOT / name).is_file()] == []


def test_no_function_is_longer_than_a_screen():
    long = {where for where, one in functions() if length(one) > MOST_LINES}
    assert long == set()


def test_no_parameters_are_tuples_of_mixed_types_beyond_a_pair():
    mixed = [
        f"{where}({argument.arg})"
        for where, one in functions()
        for path in [ROOT / "src" / where.partition(":")[0]]
        for argument in [*one.args.args, *one.args.kwonlyargs]
        if argument.annotation is not None and is_mixed(argument.annotation, path)
    ]
    assert set(mixed) == MIXED_TUPLES


def test_no_folder_of_the_library_has_more_entries_than_can_be_surveyed():
    folders = {path.parent for path in MODULES} - set(PACKAGES)
    library = [one for one in folders if not SHELLS & set(one.relative_to(ROOT / "src").parts)]
    crowded = {str(one.relative_to(ROOT / "src")): len(entries(one)) for one in library}
    assert {name: count for name, count in crowded.items() if count > MOST_ENTRIES} == {}


def entries(folder: Path) -> list[Path]:
    """Return the modules and packages in a folder."""
    modules = [path for path in folder.glob("*.py") if path.stem != "__init__"]
    return modules + [path.parent for path in folder.glob("*/__init__.py")]


@pytest.mark.parametrize(
    ("annotation", "mixed"),
    [
        ("tuple[int, str]", False),
        ("tuple[float, float, float]", False),
        ("tuple[int, ...]", False),
        ("tuple[int, str, float]", True),
        ("Callable[[tuple[int, str, NDArray[np.float64]]], None]", True),
    ],
)
def test_a_mixed_tuple_has_three_elements_of_several_types(annotation: str, mixed: bool):
    assert is_mixed(ast.parse(annotation, mode="eval").body) == mixed


def test_a_mixed_tuple_is_found_behind_an_alias_of_another_module(tmp_path: Path):
    path = tmp_path / "planted.py"
    path.write_text("from q2q_sim.link.radio_kernel import Counted\nBoth = tuple[Counted, int]\n")
    assert is_mixed(ast.parse("Both | None", mode="eval").body, path)
    assert not is_mixed(ast.parse("Unknown | None", mode="eval").body, path)


def test_the_docstring_does_not_count_as_length():
    source = 'def f():\n    """One.\n\n    Two.\n    """\n    a = 1\n    return a\n'
    made = ast.parse(source).body[0]
    assert isinstance(made, ast.FunctionDef)
    assert length(made) == 3
