"""Faults strike where the nominal flight is fastest, nearest or about to land."""

from dataclasses import replace

import numpy as np
import pytest
from licence_logs import hover

from q2q_sim.licence.fault_trials import trials_after
from q2q_sim.licence.room.trials import TrialKind


def test_faults_strike_the_fastest_vehicle_at_its_fastest_and_the_nearest_pair_at_its_nearest() -> None:
    log = hover(2)
    log.vel[500, 1, 0] = 2.0
    log.pos[600, 1, 1] = 0.7
    trials = trials_after(log)
    gap = next(one for one in trials if one.kind == TrialKind.GAP)
    assert (gap.vehicle, gap.start) == (1, pytest.approx(log.t[500]))
    swap = next(one for one in trials if one.kind == TrialKind.SWAP)
    assert ({swap.vehicle, swap.other}, swap.start) == ({0, 1}, pytest.approx(log.t[600]))
    grounded = replace(log, pos=0.0 * log.pos)
    assert trials_after(grounded) == ()


def test_of_vehicles_that_fly_one_after_another_the_fastest_is_hit_at_its_fastest() -> None:
    log = hover(3)
    for row, turn in enumerate((slice(100, 400), slice(400, 600), slice(600, 900))):
        height = log.pos[turn, row, 2].copy()
        log.pos[:, row, 2] = 0.0
        log.pos[turn, row, 2] = height
    log.pos[:, 1, 1] = 5.0  # the first is the nearest to the last, at y = 0 and 2 m
    log.vel[700, 2, 0] = 2.0
    swap, lost = (
        next(one for one in trials_after(log) if one.kind == kind)
        for kind in (TrialKind.SWAP, TrialKind.LOST)
    )
    assert (swap.vehicle, swap.other, swap.start) == (2, 0, pytest.approx(log.t[700]))
    assert (lost.vehicle, lost.start) == (2, pytest.approx(log.t[700]))


def test_a_landing_in_the_first_second_is_disturbed_from_the_start() -> None:
    log = hover()
    early = replace(log, pos=np.concatenate([log.pos[400:440], 0.0 * log.pos[40:]]))  # in the air until 0.4 s
    trials = trials_after(early)
    starts = [one.start for one in trials if one.kind in {TrialKind.GAP, TrialKind.STALE}]
    assert starts[1::2] == [0.0, 0.0]
    assert min(one.start for one in trials) == 0.0
    stale = [fault for one in trials for fault in one.capture_faults(("cf1",))]
    assert [(fault.kind, fault.start) for fault in stale] == [("stale", starts[2]), ("stale", 0.0)]
    assert [one.start for one in trials_after(log)][1] == pytest.approx(log.t[log.airborne[:, 0]][-1] - 1.0)
