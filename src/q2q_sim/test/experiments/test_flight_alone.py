"""A vehicle alone is flown again along its setpoints by the emulated firmware."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.recordings.recording_reader import recording_of_table
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.experiments.validation.error_statistics import comparison
from q2q_sim.experiments.validation.flight_alone import (
    TICK,
    FlightAlone,
    compared_alone,
    flight_alone,
    flown_positions,
    is_alone,
    setpoint_rows,
)
from q2q_sim.experiments.validation.validated_flight import as_json


def spiral(seconds: float = 12.0) -> FlightAlone:
    """Return the setpoints of a vehicle alone that climbs on a circle, with nothing flown."""
    t = TICK * np.arange(round(seconds / TICK))
    ref = np.stack([0.5 * np.cos(t), 0.5 * np.sin(t), 1.0 + 0.1 * np.sin(0.7 * t)], axis=-1)
    start = np.array([0.0, 0.0, 0.0, 1.0])
    return FlightAlone("spiral", np.tile(ref[0], (len(t), 1)), ref, np.zeros(3), start)


def test_a_vehicle_alone_validates_in_its_own_air_and_not_with_another_vehicle():
    plan = spiral()
    setpoints = setpoint_rows(plan)
    path = flown_positions(plan, setpoints, CRAZYFLIE_2_0, WakeLaw.NONE, 0)
    away = np.linalg.norm(path - plan.ref_pos, axis=1)
    assert 0.1 < away[-200:].max() < 0.7  # setpoints without velocity lead
    flight = replace(plan, pos=path)
    same = compared_alone(flight, CRAZYFLIE_2_0, WakeLaw.NONE, range(3))
    assert comparison([same.vertical]).z_rms_ratio == pytest.approx(1.0, abs=1e-9)
    assert comparison([same.lateral]).correlation == pytest.approx(1.0, abs=1e-9)
    assert comparison([same.lateral]).spectrum_db == pytest.approx(0.0, abs=1e-6)
    weak = compared_alone(flight, replace(CRAZYFLIE_2_0, mass=0.040), WakeLaw.NONE, range(3))
    assert comparison([weak.vertical]).spectrum_db > 0.1
    text = as_json([], [same])["alone"]
    assert isinstance(text, dict)
    assert text["pooled"]["n"] == len(path)
    assert text["flights"]["spiral"]["lateral"]["n"] == 2 * len(path)


def test_a_log_of_setpoints_alone_is_flown_and_a_lost_vehicle_refused(tmp_path: Path):
    plan = spiral(seconds=8.0)
    t = TICK * np.arange(len(plan.pos))
    level = np.tile(plan.quat, (len(t), 1))
    names = "t,x,y,z,qx,qy,qz,qw,xref,yref,zref"
    table = tmp_path / "spiral.csv"
    for shift in (0.0, 3.0):
        columns = np.column_stack([t, plan.ref_pos + shift, level, plan.ref_pos])
        np.savetxt(table, columns, delimiter=",", header=names, comments="")
        recording = recording_of_table(table)
        assert is_alone(recording)
        if shift == 0.0:
            # velocities come by the mocap filter, which is 0.2 mm off while it converges
            np.testing.assert_allclose(flight_alone(recording).pos, plan.ref_pos[:-1], atol=5e-4)
        else:
            with pytest.raises(ValueError, match=r"spiral cannot be flown again: .* 5\.2 m from its"):
                flight_alone(recording)
