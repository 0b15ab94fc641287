"""The emulated firmware against tables of the real one, and the check that holds it to them."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from q2q_sim.commands.firmware_check import main
from q2q_sim.firmware_check.table_rows import CheckRow, CheckTable
from q2q_sim.firmware_check.tolerances import FirmwareVerdict, Tables, compare, tolerance_checks
from q2q_sim.tools.check_firmware import tables_in

FOLDER = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data")) / "firmware"
pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(), reason=f"tables of the real firmware are not at {FOLDER}: set Q2Q_DATA"
)
NAMES = ("controllers", "planner", "supervisor", "mixer", "compensation")


@pytest.fixture(scope="module")
def tables() -> Tables:
    """Return the tables."""
    return tables_in(FOLDER)


@pytest.fixture(scope="module")
def verdict(tables: Tables) -> FirmwareVerdict:
    """Return what differs from them."""
    return compare(tables)


def first_case(table: CheckTable) -> list[CheckRow]:
    """Return the beginning of the first case."""
    return [row for row in table if row.get("case") == table[0].get("case")][:40]


def without(table: list[CheckRow], at: int, **values: str) -> list[CheckRow]:
    """Return the table with other values in one row."""
    return [*table[:at], {**table[at], **values}, *table[at + 1 :]]


def test_every_difference_is_within_its_tolerance(verdict: FirmwareVerdict) -> None:
    assert [one for one in tolerance_checks(verdict) if not one.within] == []
    assert min(verdict.controllers.cases, verdict.planner.cases, verdict.supervisor.cases) >= 3


def test_a_wrong_number_in_each_table_is_found(tables: Tables) -> None:
    """Each column that is compared, once, in the first case: what is added is beyond its tolerance."""
    small = Tables(*(first_case(getattr(tables, name)) for name in NAMES))
    control, plan, state = (list(one) for one in (small.controllers, small.planner, small.supervisor))
    changed = replace(
        small,
        controllers=without(
            control, 9, pitch=str(float(control[9]["pitch"]) + 4), m3=str(float(control[9]["m3"]) + 9)
        ),
        planner=without(plan, 1, answer="16"),
        supervisor=without(state, 5, state="8", info=str(int(state[5]["info"]) ^ 256)),
        mixer=without(list(small.mixer), 0, m2="0"),
        compensation=without(list(small.compensation), 5, ratio="23884.6"),
    )
    changed = replace(
        changed,
        planner=[
            {**row, "py": str(float(row["py"]) + 2e-4), "vz": str(float(row["vz"] or 0) + 2e-3),
             "ax": str(float(row["ax"] or 0) + 2e-2)}
            if row["packet"] != "start" else row
            for row in changed.planner
        ],
    )  # fmt: skip
    assert [one.within for one in tolerance_checks(compare(changed))] == [False] * 10


def test_the_tool_prints_json_alone_and_ends_with_the_verdict(
    tables: Tables, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in NAMES:
        rows = first_case(getattr(tables, name))
        lines = [",".join(rows[0]), *(",".join(row.values()) for row in rows)]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    assert main([str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {name: list(part) for name, part in found.items()} == {
        "controllers": ["cases", "max_pwm", "max_motor_pwm"],
        "planner": ["cases", "max_pos_m", "max_vel_mps", "max_acc_mps2", "answers_differ"],
        "supervisor": ["cases", "states_differ", "info_differ"],
        "mixer": ["max_motor_pwm"],
        "compensation": ["max_ratio"],
    }
    text = (tmp_path / "compensation.csv").read_text()
    (tmp_path / "compensation.csv").write_text(text.replace("23883.5723", "20000.0"))
    assert main([str(tmp_path), "--json", str(tmp_path / "found.json")]) == 1
    assert "OUT" in capsys.readouterr().out
    assert json.loads((tmp_path / "found.json").read_text())["compensation"]["max_ratio"] > 0.05
    (tmp_path / "mixer.csv").unlink()
    assert main([str(tmp_path)]) == 2
