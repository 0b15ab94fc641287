"""Every tool that reads recorded flights refuses a bag in millimetres, in the same words."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.commands import identify
from q2q_model.signals.values import MocapFrame
from q2q_sim.commands import learn_air, replay_page, report, validate

TOOLS: dict[str, tuple[Callable[[Sequence[str]], int], tuple[str, ...]]] = {
    "identify": (identify.main, ("--out", "{out}.q2q")),
    "learn_air": (learn_air.main, ("--out", "{out}.air")),
    "replay_page": (replay_page.main, ("--out", "{out}.html")),
    "report": (report.main, ("--out", "{out}")),
    "validate": (validate.main, ("--air", "room")),
}


def bag_of_height(path: Path, height: float) -> Path:
    """Return a bag of a vehicle that hovers at a height."""
    with BagWriter(path) as bag:
        for tick in range(5):
            level = np.array([[0.0, 0.0, 0.0, 1.0]])
            frame = MocapFrame(0.01 * tick, ("cf1",), np.array([[0.0, 0.0, height]]), level)
            bag.write_signal("/mocap", 10_000_000 * tick, frame)
    return path


@pytest.mark.parametrize("tool", TOOLS)
def test_a_bag_in_millimetres_is_refused(
    tool: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main, options = TOOLS[tool]
    bag = bag_of_height(tmp_path / "mm", 1000.0)
    assert main([str(bag), *(option.format(out=tmp_path / "made") for option in options)]) == 1
    message = "x, y, z of cf1 in mm reach 1000 in the median, 50 m is the maximum: are they in metres?"
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith(f"{tool}: {message}")


def test_a_bag_in_metres_is_replayed(tmp_path: Path) -> None:
    bag = bag_of_height(tmp_path / "metres", 1.0)
    assert replay_page.main([str(bag), "--out", str(tmp_path / "page.html")]) == 0
