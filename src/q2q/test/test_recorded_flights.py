"""Recorded flights in Python: what the command line notes is a warning."""

from pathlib import Path

import numpy as np
import pytest

import q2q
from q2q_model.bag import BagWriter
from q2q_model.signals.values import MocapFrame

LEVEL = np.array([[0.0, 0.0, 0.0, 1.0]])


def turned_bag(path: Path) -> Path:
    """Write a circle 1 m above the floor in a frame whose z is down."""
    with BagWriter(path) as bag:
        for tick, angle in enumerate(np.linspace(0.0, 2.0 * np.pi, 200)):
            pos = np.array([[np.cos(angle), np.sin(angle), -1.0]])
            bag.write_signal("/mocap", 10_000_000 * tick, MocapFrame(0.01 * tick, ("cf1",), pos, LEVEL))
    return path


def test_a_flight_whose_z_seems_to_be_down_is_a_warning(tmp_path: Path) -> None:
    bag = turned_bag(tmp_path / "turned")
    with pytest.warns(UserWarning, match=r"flight turned: z is below -0.1 m in 100% .*: z may be down"):
        q2q.read_bag(bag, "crazyflie_2_0")
    with (
        pytest.warns(UserWarning, match=r"flight turned: z is below -0.1 m in 100% .*: z may be down"),
        pytest.raises(ValueError, match="reference"),  # it has none
    ):
        q2q.identify(bag, vehicle="crazyflie_2_0")
