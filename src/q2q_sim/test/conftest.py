"""Simulated vehicles that speak CRTP; tests of this folder may import its other modules."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from cflib_fleet import CflibFleet

if TYPE_CHECKING:
    from crtp_stage import Stage

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def grounded() -> CflibFleet:
    """Return one vehicle on the ground, half a second after its start: ready to fly."""
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(0.5)
    return crazyflies


@pytest.fixture(scope="session")
def toc_cache(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a folder for the tables that cflib fetches from a vehicle once."""
    return str(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def stage(
    monkeypatch: pytest.MonkeyPatch, toc_cache: str, request: pytest.FixtureRequest
) -> "Iterator[Stage]":
    """Return a room for cflib's examples; the parameter is the number of vehicles and their positioning."""
    from crtp_stage import staged

    yield from staged(monkeypatch, toc_cache, *getattr(request, "param", (1, "deck")))
