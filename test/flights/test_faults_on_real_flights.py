"""Real flights with injected faults: no outlier passes as truth, a true jump is found, nothing diverges."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.tables.flight_table import flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.signals.values import Array, MocapFrame, Names, SwarmState, TrackStatus, index_of

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[3] / "shared" / "data"))
FLIGHTS = sorted(DATA.glob("*/*.parquet")) or [Path("none")]
JUMP_M, FOUND_S = 1.0, 0.1
"""What the issue asks: a true jump of 1 m is followed within 0.1 s."""
OUTLIER_SHARE = 0.01
"""Of samples: one a second and vehicle."""
FALSE_M = 0.06
"""A state farther from where the clean flight was believes something else: jump_max 0.04, and a coasted tick
at the flights' largest acceleration and speed."""
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")


def frames_of(path: Path) -> tuple[list[MocapFrame], Names]:
    table = flight_table(read_columns(path))
    made = [one for one in signals_of(table)["/mocap"] if isinstance(one, MocapFrame)]
    return made, table.names


def filtered(frames: list[MocapFrame], names: Names) -> list[SwarmState]:
    mocap_filter = MocapFilter(MocapFilterParams(), names)
    return [mocap_filter.update(frame) for frame in frames]


def column(states: list[SwarmState], attribute: str) -> Array:
    return np.stack([getattr(state, attribute) for state in states])


def moved(frame: MocapFrame, rows: Array, by: Array) -> MocapFrame:
    pos = frame.pos.copy()
    pos[rows] += by
    return replace(frame, pos=pos)


def struck(frames: list[MocapFrame], names: Names, jump_at: float) -> tuple[list[MocapFrame], Array]:
    """Return frames with outliers and a jump of the first vehicle, and whose sample lies, (T, n)."""
    rng = np.random.default_rng(0)
    made, lied = [], np.zeros((len(frames), len(names)), dtype=bool)
    for k, frame in enumerate(frames):
        carried = frame.t >= jump_at
        first = np.flatnonzero(np.array(frame.names) == names[0])
        here = moved(frame, first, np.array([JUMP_M, 0.0, 0.0])) if carried else frame
        rows = np.flatnonzero(rng.random(len(frame.names)) < OUTLIER_SHARE)
        away, size = rng.standard_normal((len(rows), 3)), rng.uniform(0.3, 5.0, (len(rows), 1))
        if frame.t > frames[0].t + 1.0 and abs(frame.t - jump_at) > 1.0:
            here = moved(here, rows, away / np.linalg.norm(away, axis=1, keepdims=True) * size)
            lied[k, index_of([frame.names[row] for row in rows], names)] = True
        made.append(here)
    return made, lied


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.stem)
def test_a_real_flight_comes_through_outliers_and_a_true_jump(path: Path) -> None:
    frames, names = frames_of(path)
    plain = filtered(frames, names)
    clean, known = column(plain, "pos"), column(plain, "status") == TrackStatus.TRACKED
    t = np.array([frame.t for frame in frames])
    jump_at = float(t[len(t) // 2])
    faulty, lied = struck(frames, names, jump_at)
    states = filtered(faulty, names)
    pos, status = column(states, "pos"), column(states, "status")
    truth = clean.copy()
    truth[t >= jump_at, 0, 0] += JUMP_M
    off = np.linalg.norm(pos - truth, axis=2)
    assert lied.any()
    assert np.isfinite(pos).all()
    # no outlier is accepted: where one came, its vehicle coasts, and is where it was
    assert not (status[lied] == TrackStatus.TRACKED).any()
    assert off[lied & known].max() < FALSE_M
    # a true jump is accepted within 0.1 s, by a vehicle that is in sight then
    found = (t >= jump_at + FOUND_S) & known[:, 0] & (status[:, 0] == TrackStatus.TRACKED)
    assert off[found, 0].max() < FALSE_M
    soon = (t >= jump_at) & (t <= jump_at + FOUND_S + 0.005) & known[:, 0]
    assert (off[soon, 0] < FALSE_M).any()
    # nothing diverges: whoever is tracked is where the clean flight was, up to the end
    calm = known & (status == TrackStatus.TRACKED) & (np.abs(t - jump_at) > FOUND_S)[:, None]
    assert off[calm].max() < FALSE_M
