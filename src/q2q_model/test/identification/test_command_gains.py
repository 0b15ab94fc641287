"""Gains from commands are those that flew, whatever the rows in which the command was no answer to them."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import CALM, LOOP, PASSES, Pass, made_flight, record_of

from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


def test_gains_from_commands_are_those_that_flew_and_lie_inside_their_interval() -> None:
    loop = replace(LOOP, offset=0.15)
    fit = gains_from_commands([record_of(Pass(loop=loop, start=0.2, noise=1e-4))])
    assert fit.k_p.low <= loop.k_p <= fit.k_p.high
    assert fit.k_d.low <= loop.k_d <= fit.k_d.high
    assert fit.k_p.high - fit.k_p.low < 0.01 * loop.k_p
    assert fit.needs_offset
    assert not fit.needs_integral
    assert fit.loop.offset == pytest.approx(0.15, rel=1e-6)


def test_terms_that_did_not_fly_are_not_asked_for() -> None:
    fit = gains_from_commands([record_of(PASSES[0])])
    assert not fit.needs_offset
    assert not fit.needs_integral
    assert fit.loop.k_i == fit.loop.offset == 0.0


def test_rows_in_which_a_limit_cut_the_command_do_not_move_the_gains() -> None:
    record = record_of(CALM)
    commanded_acc = record.commanded_acc.copy()
    commanded_acc[100:150] = 0.05
    fit = gains_from_commands([replace(record, commanded_acc=commanded_acc)])
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)  # 50 of 6000 rows, all wrong the same way


def test_the_ground_and_holes_in_the_positions_do_not_move_the_gains() -> None:
    made = made_flight(CALM)
    stands, unseen = np.arange(2000), np.arange(2300, 2700)
    pos, vel, thrust = made.pos.copy(), made.vel.copy(), made.thrust.copy()
    pos[stands, :, 2], vel[stands], thrust[stands] = 0.0, 0.0, 0.0  # below a reference 1 m up, motors off
    pos[unseen, 1], vel[unseen, 1] = np.nan, np.nan
    mocap = np.where(np.isfinite(pos), made.mocap_pos, np.nan)
    record = altitude_record(replace(made, pos=pos, vel=vel, thrust=thrust, mocap_pos=mocap), CRAZYFLIE_2_0)
    fit = gains_from_commands([record])
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)  # noise of 0.1 mm in an error of 10 mm
    assert fit.k_d.value == pytest.approx(LOOP.k_d, rel=1e-3)
    assert np.isnan(record.commanded_acc[stands]).all()
    assert np.isnan(record.commanded_acc[unseen, 1]).all()
    assert np.isfinite(record.commanded_acc[unseen, 0]).all()


def test_a_flight_without_commands_is_refused_with_the_way_out() -> None:
    record = record_of(CALM)
    missing = "0 rows with thrust commands in 1 flight, at references with rates; must be at least 200"
    with pytest.raises(ValueError, match=missing):  # two pieces of it between holes
        gains_from_commands([replace(record, commanded_acc=np.full_like(record.commanded_acc, np.nan))] * 2)
