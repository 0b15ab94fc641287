"""Every tool that reads recorded flights refuses positions and references in millimetres in one sentence."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.commands import identify
from q2q_model.signals.values import Array, MocapFrame, SwarmSetpoint
from q2q_sim.commands import learn_air, replay_page, report, validate

TOOLS: dict[str, tuple[Callable[[Sequence[str]], int], tuple[str, ...]]] = {
    "identify": (identify.main, ("--out", "{out}.q2q")),
    "learn_air": (learn_air.main, ("--out", "{out}.air")),
    "replay_page": (replay_page.main, ("--out", "{out}.html")),
    "report": (report.main, ("--out", "{out}")),
    "validate": (validate.main, ("--air", "room")),
}


def bag_of_height(path: Path, height: float, reference: float | None = None) -> Path:
    """Return a bag of a vehicle that hovers at a height, with a reference of another."""
    still, level = np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]])
    with BagWriter(path) as bag:
        for tick in range(5):
            t, stamp = 0.01 * tick, 10_000_000 * tick
            bag.write_signal("/mocap", stamp, MocapFrame(t, ("cf1",), above(height), level))
            if reference is not None:
                status = np.zeros(1, dtype=np.uint8)
                given = SwarmSetpoint(
                    t, ("cf1",), above(reference), still, still, np.zeros(1), np.zeros(1), status
                )
                bag.write_signal("/reference", stamp, given)
    return path


def above(height: float) -> Array:
    """Return a position above the origin, (1, 3)."""
    return np.array([[0.0, 0.0, height]])


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize(
    ("heights", "what"), [((1000.0, None), "cf1"), ((1.0, 1000.0), "the reference of cf1")]
)
def test_a_bag_in_millimetres_is_refused(
    tool: str,
    heights: tuple[float, float | None],
    what: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    main, options = TOOLS[tool]
    bag = bag_of_height(tmp_path / "mm", *heights)
    assert main([str(bag), *(option.format(out=tmp_path / "made") for option in options)]) == 1
    message = (
        f"x, y, z of {what} in mm reach 1000 m in the median (maximum 50 m): check that they are in metres"
    )
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith(f"{tool}: {message}")


def test_a_bag_in_metres_is_replayed(tmp_path: Path) -> None:
    bag = bag_of_height(tmp_path / "metres", 1.0)
    assert replay_page.main([str(bag), "--out", str(tmp_path / "page.html")]) == 0
