"""Pilots of simulated vehicles that speak CRTP; tests of this folder may import its other modules."""

import sys
from pathlib import Path

import numpy as np
import pytest

from q2q_sim.crtp.pilot import Pilot

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def grounded() -> Pilot:
    """Return one vehicle on the ground, half a second after its start: ready to fly."""
    pilot = Pilot(np.zeros((1, 4)))
    pilot.fly(0.5)
    return pilot
