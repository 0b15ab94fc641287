"""Signals of a bag are joined by stamp to a flight; clocks that do not allow it are refused."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from bag_signals import PAIR, STEP_NS, random_signal

from q2q_model.bag import (
    BagError,
    BagWriter,
    read_flight,
)
from q2q_model.signals.values import MocapFrame, SwarmCommand, SwarmState


def test_a_flight_is_joined_by_stamp_and_missing_is_nan(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    frames, commands = {}, {}
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(50):
            names = PAIR if tick % 5 else PAIR[1:]
            frames[tick] = random_signal(MocapFrame, tick, names, rng)
            bag.write_signal("/room/mocap", tick * STEP_NS, frames[tick])
            if tick % 3 == 0:  # commands come later than the ticks they answer
                commands[tick] = random_signal(SwarmCommand, tick, PAIR[::-1], rng)
                bag.write_signal("/room/command", tick * STEP_NS + 4_000_000, commands[tick])
    flight = read_flight(tmp_path / "bag")
    assert flight.names == PAIR[::-1]  # command names the whole swarm
    assert np.array_equal(flight.t, [tick * STEP_NS * 1e-9 for tick in range(50)])
    for tick in range(50):
        assert np.array_equal(flight.mocap_pos[tick, 0], frames[tick].pos[-1])
        assert np.isnan(flight.mocap_pos[tick, 1]).all() == (tick % 5 == 0)
        if tick in commands:
            assert np.array_equal(flight.thrust[tick], commands[tick].thrust)
        else:
            assert np.isnan(flight.thrust[tick]).all()
    assert np.isnan(flight.pos).all()


def test_clocks_that_never_meet_are_refused_with_both_spans(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(20):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
            late = random_signal(SwarmCommand, 170_000_000 + tick, PAIR, rng)
            bag.write_signal("/command", tick * STEP_NS, late)
    with pytest.raises(BagError, match=r"command \(1700000\.000 to .*mocap.*clocks are mixed"):
        read_flight(tmp_path / "bag")


def test_frames_that_all_have_one_stamp_are_no_flight(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(100):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, 0, PAIR, rng))
    with pytest.raises(BagError, match=r"all 100 messages on mocap are stamped 0 s: stamp each"):
        read_flight(tmp_path / "bag")


def test_strays_repeats_and_disorder_are_stated(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    with BagWriter(tmp_path / "bag") as bag:
        for place, tick in enumerate((0, 1, 3, 2, 4, 4)):
            bag.write_signal("/mocap", place * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
        for tick in (4, 5):
            bag.write_signal("/state", 10 * STEP_NS, random_signal(SwarmState, tick, PAIR, rng))
            bag.write_signal("/command", 10 * STEP_NS, random_signal(SwarmCommand, tick, PAIR, rng))
    with warnings.catch_warnings(record=True) as lines:
        warnings.simplefilter("always")
        flight = read_flight(tmp_path / "bag")
    text = " | ".join(str(one.message) for one in lines)
    assert "1 of 2 messages on state match no tick" in text
    assert "command" not in text  # a live controller commands on after the last tick
    assert "1 repeated stamp on mocap" in text
    assert "stamps on mocap are out of order" in text
    assert len(flight.t) == 5


def test_commands_of_one_controller_a_vehicle_join_in_a_tick_and_are_no_repeats(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    sent = [random_signal(SwarmCommand, tick, (name,), rng) for tick in range(3) for name in PAIR]
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(3):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
        for place, command in enumerate(sent):
            bag.write_signal("/command", place * STEP_NS, command)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flight = read_flight(tmp_path / "bag")
    assert flight.thrust.ravel().tolist() == [command.thrust[0] for command in sent]
