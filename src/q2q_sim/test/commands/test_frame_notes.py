"""Tools that judge a flight in a frame that seems to be wrong say so."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.flights.units_and_frames.frame_notes import frame_notes
from q2q_model.recordings.recording_reader import recording_of_bag
from q2q_model.signals.values import Array, MocapFrame
from q2q_sim.commands import replay_page, report

TICKS = 200
TOOLS: dict[str, tuple[Callable[[Sequence[str]], int], str]] = {
    "replay_page": (replay_page.main, "page.html"),
    "report": (report.main, "report"),
}
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
EXPECTED = {
    "z up": "",
    "y up": "z is below -0.1 m in 46% of the positions and y in 0%: y may be up",
    "z down": "z is below -0.1 m in 100% of the positions and above 0.1 m in 0%: z may be down",
    "w x y z": "body z of cf1 points -1.00 upwards in the median",
}
"""Frame -> note."""


def circle() -> Array:
    """Return positions on a circle around the origin, 1 m up, (T, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, TICKS, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle), np.ones(TICKS)], axis=-1)


def bag_of(path: Path, pos: Array, quat: Array) -> Path:
    """Return a bag of motion capture."""
    with BagWriter(path) as bag:
        for tick, place in enumerate(pos):
            bag.write_signal(
                "/mocap", 10_000_000 * tick, MocapFrame(0.01 * tick, ("cf1",), place[None], quat[None])
            )
    return path


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize(("frame", "expected"), EXPECTED.items())
def test_a_flight_in_another_frame_is_doubted(
    tool: str, frame: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pos = circle()
    turned = {"y up": pos[:, [0, 2, 1]] * [1.0, 1.0, -1.0], "z down": pos * [1.0, -1.0, -1.0]}.get(frame, pos)
    bag = bag_of(tmp_path / "room", turned, LEVEL[[3, 0, 1, 2]] if frame == "w x y z" else LEVEL)
    main, out = TOOLS[tool]
    assert main([str(bag), "--vehicle", "crazyflie_2_0", "--out", str(tmp_path / out)]) == 0
    said = capsys.readouterr().err
    notes = [line for line in said.splitlines() if f"{tool}: flight room: " in line]
    assert said.count("flight room: ") == len(notes)
    assert len(notes) == bool(expected)
    assert all(expected in note for note in notes)


def test_the_frame_of_a_simulator_is_known(tmp_path: Path) -> None:
    flight = recording_of_bag(bag_of(tmp_path / "room", circle(), LEVEL[[3, 0, 1, 2]])).flight
    assert len(frame_notes(flight)) == 1
    assert frame_notes(replace(flight, true_pos=flight.mocap_pos)) == []
