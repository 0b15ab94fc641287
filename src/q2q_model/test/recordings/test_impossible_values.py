"""Values that no small vehicle can have are left out of a flight, and reported."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagReader, BagRepairWarning, BagWriter, read_flight
from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.recordings.impossible_values import possible_flight, possible_log
from q2q_model.recordings.recording_reader import recording_of_bag
from q2q_model.signals.values import SwarmCommand

BAG = Path(__file__).parents[4] / "bags" / "table2_1"


def test_a_sound_flight_is_as_it_is() -> None:
    flight = read_flight(BAG)
    found, remarks = possible_flight(flight)
    assert found is flight
    assert remarks == []


def test_an_impossible_number_or_vector_is_left_out_with_vehicle_and_time() -> None:
    flight = read_flight(BAG)
    thrust, ref_pos = flight.thrust.copy(), flight.ref_pos.copy()
    thrust[[300, 301], 0] = 1e300, np.inf
    ref_pos[400, 1, 2] = -1e200
    found, remarks = possible_flight(replace(flight, thrust=thrust, ref_pos=ref_pos))
    most = "maximum 10000 (SI units)"
    assert sorted(remarks) == [
        f"ref_pos of cf2 is 1e+200 at {flight.t[400]:.3f} s, {most}: 1 such value left out",
        f"thrust of cf1 is 1e+300 at {flight.t[300]:.3f} s, {most}: 2 such values left out",
    ]
    thrust[[300, 301], 0], ref_pos[400, 1] = np.nan, np.nan
    np.testing.assert_array_equal(found.thrust, thrust)
    np.testing.assert_array_equal(found.ref_pos, ref_pos)
    assert found.pos is flight.pos


def test_of_a_log_forces_count_and_columns_in_other_units_do_not() -> None:
    values = np.full((5, 1, 2), 65535.0)
    log = FlightLog(np.arange(5.0), ("cf1",), ("faz_est", "m1"), ("", ""), values)
    found, remarks = possible_log(log)
    assert remarks == [
        "faz_est of cf1 is 6.55e+04 at 0.000 s, maximum 10000 (SI units): 5 such values left out"
    ]
    assert np.isnan(found.column("faz_est")).all()
    assert (found.column("m1") == 65535.0).all()
    sound = replace(log, columns=("vbat", "m1"))
    assert possible_log(sound) == (sound, [])


def test_a_flight_with_a_command_of_1e160_newtons_is_identified_as_without_it(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "damaged") as bag:
        for number, one in enumerate(BagReader(BAG).signals()):
            signal = one.signal
            if isinstance(signal, SwarmCommand) and 2000 < number < 2020:
                signal = replace(signal, thrust=np.full(len(signal.names), 1e160))
            bag.write_signal(one.topic, one.stamp_ns, signal)
    with pytest.warns(BagRepairWarning, match=r"flight damaged: thrust of cf1 is 1e\+160 at"):
        damaged = recording_of_bag(tmp_path / "damaged")
    gains = [
        identify([one], ProcedureParams(), lambda _: None).gains for one in (recording_of_bag(BAG), damaged)
    ]
    np.testing.assert_allclose(gains[0].loop.k_p, gains[1].loop.k_p, rtol=1e-3)  # of some rows less
