"""The calls of cflib's examples of logs and parameters run to the end (table in test_crtp_examples)."""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from threading import Event

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie.mem import MemoryElement
from cflib.crazyflie.syncLogger import SyncLogger
from cflib.utils.param_file_helper import ParamFileHelper
from crtp_stage import ANSWER_S, Stage, log_of

ATTITUDE = ("stabilizer.roll", "stabilizer.pitch", "stabilizer.yaw")


def test_a_log_calls_back_with_what_it_was_asked_for(stage: Stage) -> None:
    seen: list[tuple[int, dict[str, float]]] = []
    with stage.crazyflie() as scf:
        log = log_of("Stabilizer", 100, ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", *ATTITUDE))
        log.add_variable("pm.vbat", "FP16")
        scf.cf.log.add_config(log)
        log.data_received_cb.add_callback(lambda stamp, data, _: seen.append((stamp, data)))
        log.start()
        stage.clock.sleep(5.0)
    stamps = [stamp for stamp, _ in seen]
    assert np.diff(stamps).tolist() == [100] * (len(stamps) - 1)
    assert seen[-1][1]["pm.vbat"] == pytest.approx(4.2, abs=0.01)


def test_a_log_is_read_entry_by_entry(stage: Stage) -> None:
    with stage.crazyflie() as scf, SyncLogger(scf, log_of("Stabilizer", 10, ATTITUDE)) as log:
        stamps = [stamp for stamp, _, _ in islice(log, 200)]
    assert np.diff(stamps).tolist() == [10] * 199


def test_a_parameter_calls_back_whenever_it_is_set(stage: Stage) -> None:
    output, twice = [], Event()
    with stage.crazyflie() as scf:
        scf.wait_for_params()

        def note(_: str, value: str) -> None:
            output.append(value)
            if output[-2:] == ["2", "1"]:
                twice.set()

        scf.cf.param.add_update_callback(group="stabilizer", name="estimator", cb=note)
        scf.cf.param.set_value("stabilizer.estimator", 2)
        scf.cf.param.set_value("stabilizer.estimator", 1)
        assert twice.wait(ANSWER_S), output


def test_every_parameter_is_fetched_and_one_is_set_and_read_back(stage: Stage) -> None:
    fetched: dict[str, str] = {}
    done = Event()
    with stage.crazyflie() as scf:
        scf.wait_for_params()
        names = [f"{group}.{one}" for group, all_of in scf.cf.param.toc.toc.items() for one in all_of]
        fetched = {name: scf.cf.param.get_value(name) for name in names}
        scf.cf.param.add_update_callback(
            group="pid_attitude",
            name="pitch_kd",
            cb=lambda _, value: done.set() if abs(float(value) - 0.1234) < 1e-6 else None,
        )
        scf.cf.param.set_value("pid_attitude.pitch_kd", 0.1234)
        assert done.wait(ANSWER_S)
    assert fetched["cpu.flash"] == "1024"
    assert fetched["deck.bcFlow2"] == "1"
    assert stage.crazyflies.firmware().parameters["pid_attitude.pitch_kd"] == pytest.approx(0.1234)


def test_the_eeprom_has_the_stock_radio_and_keeps_another_channel(stage: Stage) -> None:
    """As in cflib's memory/read_eeprom and write_eeprom of earlier years."""
    with stage.crazyflie() as scf:
        (eeprom,) = scf.cf.mem.get_mems(MemoryElement.TYPE_I2C)

        def looked() -> tuple[bool, int, int]:
            done = Event()
            eeprom.update(lambda _: done.set())
            assert done.wait(ANSWER_S)
            return eeprom.valid, eeprom.elements["radio_channel"], eeprom.elements["radio_address"]

        assert looked() == (True, 80, 0xE7E7E7E7E7)
        eeprom.elements["radio_channel"], written = 90, Event()
        eeprom.write_data(lambda *_: written.set())
        assert written.wait(ANSWER_S)
        assert looked() == (True, 90, 0xE7E7E7E7E7)


def answered(ask: Callable[[Callable[[str, object], None]], None]) -> object:
    """Return what a call of cflib answers by callback."""
    answers: list[object] = []
    come = Event()

    def take(_: str, answer: object) -> None:
        answers.append(answer)
        come.set()

    ask(take)
    assert come.wait(ANSWER_S)
    return answers[0]


def test_the_rings_effect_is_stored_outlives_and_is_cleared(stage: Stage) -> None:
    with stage.crazyflie() as scf:
        scf.wait_for_params()
        param = scf.cf.param
        persistent = [
            f"{group}.{name}"
            for group, members in param.toc.toc.items()
            for name, element in members.items()
            if element.is_persistent()
        ]
        assert "ring.effect" in persistent
        states = [
            answered(lambda take, name=name: param.persistent_get_state(name, take)) for name in persistent
        ]
        assert None not in states
        param.set_value("ring.effect", 10)
        assert answered(lambda take: param.persistent_store("ring.effect", take)) is True
        state = answered(lambda take: param.persistent_get_state("ring.effect", take))
        assert (state.is_stored, state.default_value, state.stored_value) == (True, 6, 10)
        assert answered(lambda take: param.persistent_clear("ring.effect", take)) is True
        assert not answered(lambda take: param.persistent_get_state("ring.effect", take)).is_stored


def test_parameters_of_a_file_are_stored(stage: Stage, tmp_path: Path) -> None:
    state = "{default_value: 6, is_stored: true, stored_value: 13}"
    file = tmp_path / "params.yaml"
    file.write_text(f"params: {{ring.effect: {state}}}\ntype: persistent_param_state\nversion: '1'\n")
    with stage.crazyflie() as scf:
        scf.wait_for_params()
        assert ParamFileHelper(scf.cf).store_params_from_file(str(file))
    stage.crazyflies.firmware().boot()
    assert stage.crazyflies.firmware().parameters["ring.effect"] == 13
