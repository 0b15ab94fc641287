"""The firmware app compiled for this machine, and vehicles at rest for it."""

import shutil
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from q2q_control.onboard.app_folder import write_app
from q2q_control.onboard.model_header import AppRates
from q2q_control.onboard.native_app import AppLibrary, StepInput, compile_app
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import MOVING_LAW, Jet
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: install one to test the app")
TICK_US = 10_000
STACKED = replace(MOVING_LAW, loading=0.6, absorption=1.5, velocity_share=0.6)
"""Jet of real triples: docs/real_flights.md."""
TICKS = AppRates(broadcast_hz=100.0)
"""Every tick of a motion is broadcast, as the predictor sees it."""


@lru_cache(maxsize=8)
def library(jet: Jet, rates: AppRates = TICKS, residual: ResidualProcess | None = None) -> AppLibrary:
    """Return the compiled app of a jet."""
    with TemporaryDirectory() as made:
        write_app(Path(made) / "app", ModelFile(jet, residual=residual), CRAZYFLIE_2_0, rates)
        return compile_app(Path(made) / "app")


def at_rest(now_us: int, own: Array, **values: float) -> StepInput:
    """Return the input of a step of a vehicle that hovers."""
    return StepInput(now_us, own, **({"force_up": GRAVITY, "thrust": GRAVITY, "flying": True} | values))


def hover(x: float, y: float, z: float) -> Array:
    """Return position, velocity and thrust axis of a vehicle that hovers, (9,)."""
    return np.array([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
