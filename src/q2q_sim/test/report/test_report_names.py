"""A report of vehicles and flights of any name: where its pictures are written, and what they say."""

import json
from pathlib import Path

import numpy as np
import pytest
from resting_signals import level_command, resting_state

from q2q_model.bag import BagReader, BagWriter, read_flight
from q2q_model.signals.values import CommandStatus, MocapFrame
from q2q_sim.commands import report
from q2q_sim.report.figures import KINDS, PlotCurve, plot_quantity
from q2q_sim.report.panels import picture_file
from q2q_sim.tools.distinct_names import distinct_names

ODD = ("../../up", "a/b", "c" * 300, r"cf$\foo$")


def recorded_bag(path: Path, names: tuple[str, ...]) -> Path:
    """Return a bag in which vehicles rise by 1 cm a tick, a metre apart."""
    pos = np.zeros((len(names), 3))
    quat = np.tile([0.0, 0.0, 0.0, 1.0], (len(names), 1))
    pos[:, 0] = np.arange(len(names))
    with BagWriter(path) as bag:
        for k in range(20):
            t, pos[:, 2] = 0.01 * k, 0.01 * k
            bag.write_signal("/mocap", round(1e9 * t), MocapFrame(t, names, pos, quat))
            state = resting_state(t, names, pos)
            bag.write_signal("/state", round(1e9 * t), state)
    return path


def test_no_name_of_a_vehicle_writes_outside_the_folder_of_the_report(tmp_path: Path) -> None:
    names = (*ODD, str(tmp_path / "absolute" / "cf1"))
    out = tmp_path / "some" / "deep" / "report"
    bag = recorded_bag(tmp_path / "bag", names)
    assert report.main([str(bag), "--vehicle", "crazyflie_2_0", "--out", str(out)]) == 0
    pictures = set(tmp_path.rglob("*.png"))
    assert {path.parent for path in pictures} == {out}
    assert len(pictures) == len(names), "one altitude each, none written over another's"


def test_a_flight_whose_folder_begins_with_an_underscore_is_in_the_legends(tmp_path: Path) -> None:
    flight = read_flight(recorded_bag(tmp_path / "_day", ("cf1",)))
    figure = plot_quantity(KINDS["altitude"], [PlotCurve(flight, "_day"), PlotCurve(flight, "other")], "cf1")
    (legend,) = figure.legends
    assert [text.get_text().strip() for text in legend.get_texts()] == ["_day", "other", "reference"]


@pytest.mark.parametrize("path", [".", "../day"])
def test_a_bag_has_the_name_of_its_folder_from_wherever_it_is_read(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = recorded_bag(tmp_path / "day", ("cf1",))
    monkeypatch.chdir(bag)
    assert distinct_names([Path(path)]) == ["day"]
    assert read_flight(Path(path)).name == "day"


@pytest.mark.parametrize("again", ["day", "./day", "other/../day"])
def test_a_flight_that_is_given_twice_is_refused(
    again: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded_bag(tmp_path / "day", ("cf1",))
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)
    assert report.main(["day", "--compare", again, "--json", "it.json"]) == 1
    assert f"{Path(again)} is given twice: give each flight once" in capsys.readouterr().err
    assert not Path("it.json").exists()


def test_the_json_has_the_numbers_of_commands_and_separation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = recorded_bag(tmp_path / "day", ("cf1", "cf2"))
    with BagWriter(tmp_path / "commanded") as copied:
        for one in BagReader(bag).signals(["/mocap", "/state"]):
            copied.write_signal(one.topic, one.stamp_ns, one.signal)
        for k in range(20):
            none, status = np.zeros(2), np.array([CommandStatus.OK, CommandStatus.HOLD * (k < 5)], np.uint8)
            command = level_command(0.01 * k, ("cf1", "cf2"), none, status=status)
            copied.write_signal("/command", 10_000_000 * k, command)
    monkeypatch.chdir(tmp_path)
    assert report.main(["commanded", "--vehicle", "crazyflie_2_0", "--json", "it.json"]) == 0
    one, two = json.loads(Path("it.json").read_text(encoding="utf-8"))["commanded"].values()
    shown = ("saturated_percent", "fallback_percent", "min_separation_m", "zone_time_s")
    assert [one[key] for key in shown] == [0.0, 0.0, 1.0, 0.0]
    assert [two[key] for key in shown] == [0.0, 25.0, 1.0, 0.0]


@pytest.mark.parametrize("name", ["cf1", "day-2.b", "名前"])
def test_an_ordinary_name_is_that_of_its_picture(name: str, tmp_path: Path) -> None:
    assert picture_file(tmp_path, name, "thrust") == tmp_path / f"{name}_thrust.png"
