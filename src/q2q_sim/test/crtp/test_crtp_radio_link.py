"""The link of the node `radio` over cflib and UDP to a vehicle that cannot be given its parameters."""

import math
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from link_waits import ANSWER_S, fly_until, until

from cflib_fleet import CflibFleet
from q2q_control.radio.link.cflib_link import CflibLink
from q2q_control.radio.link.firmware_params import (
    APP,
    CONTROLLER,
    TableEntry,
    firmware_params,
    required_with_app,
    unsettable,
)
from q2q_control.radio.link.firmware_settings import FirmwareSettings
from q2q_control.radio.link.vehicle_link import LinkHealth
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams

OWN_URI = f"radio://0/80/2M/{os.getpid():010X}"
"""A URI of no other test that runs on this machine."""
TABLE = {
    "locSrv.extPosStdDev": TableEntry("<f", writable=True),
    "stabilizer.controller": TableEntry("<B", writable=True),
    "firmware.revision0": TableEntry("<L", writable=False),
}


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (
            "locSrv.extPosStDev=0.1",
            "it has no parameter locSrv.extPosStDev (firmware_params): the nearest are locSrv.extPosStdDev",
        ),
        ("xy.z=1", "it has no parameter xy.z (firmware_params): no name in its table is similar"),
        ("firmware.revision0=1", "its firmware.revision0 is read-only (firmware_params): leave it out"),
        (
            "stabilizer.controller=256",
            "its stabilizer.controller cannot be 256 (firmware_params): it has 8 bits",
        ),
        (
            "stabilizer.controller=nan",
            "its stabilizer.controller cannot be nan (firmware_params): it has 8 bits",
        ),
    ],
)
def test_a_parameter_that_a_vehicle_cannot_be_given_is_named_with_the_reason(asked: str, why: str) -> None:
    expected = firmware_params(("locSrv.extPosStdDev=0.001", asked), "command")
    assert unsettable(expected, TABLE) == {asked.partition("=")[0]: why}


def test_what_a_vehicle_can_be_given_is_not_refused() -> None:
    assert unsettable({"locSrv.extPosStdDev": 1e-3, "stabilizer.controller": 255.0}, TABLE) == {}


@pytest.mark.parametrize(
    ("asked", "mode", "app", "required"),
    [
        ((), "setpoint", True, 6.0),
        ((), "setpoint", False, 2.0),
        (("stabilizer.controller=5",), "setpoint", True, 5.0),
        ((), "command", True, 1.0),
        ((), "command", False, 1.0),
    ],
)
def test_where_the_firmware_app_is_its_controller_is_required_for_full_states(
    asked: tuple[str, ...], mode: str, app: bool, required: float
) -> None:
    known = {*TABLE, APP} if app else TABLE
    assert required_with_app(firmware_params(asked, mode), known) == {CONTROLLER: required}


@dataclass(frozen=True)
class Element:
    """Element of cflib's table of parameters."""

    pytype: str
    access: str

    def get_readable_access(self) -> str:
        """Return RW or RO."""
        return self.access


class Held:
    """Parameters of cflib, of a vehicle that holds its controller; what is set is kept."""

    def __init__(self, controller: float, table: dict[str, TableEntry]) -> None:
        self.values, self.sent = {CONTROLLER: controller}, list[str]()
        self.toc = SimpleNamespace(toc=dict[str, dict[str, Element]]())
        for name, entry in table.items():
            group, _, own = name.partition(".")
            element = Element(entry.layout, "RW" if entry.writable else "RO")
            self.toc.toc.setdefault(group, {})[own] = element
        self.read: dict[str, Callable[[str, str], None]] = {}

    def add_update_callback(self, group: str, name: str, read: Callable[[str, str], None]) -> None:
        """Answer requests of a parameter by a call."""
        self.read[f"{group}.{name}"] = read

    def set_value(self, name: str, value: float) -> None:
        """Hold a value."""
        self.values[name] = value
        self.sent.append(name)

    def request_param_update(self, name: str) -> None:
        """Answer with the value that is held."""
        self.read[name](name, str(self.values[name]))


@pytest.mark.parametrize(
    ("app", "held", "sent", "wrong"),
    [
        (True, 6.0, ["locSrv.extPosStdDev"], ""),
        (True, 1.0, ["locSrv.extPosStdDev"], "its stabilizer.controller is 1, expected 6 (firmware_params)"),
        (False, 1.0, ["locSrv.extPosStdDev", CONTROLLER], ""),
    ],
)
def test_the_controller_is_left_to_the_firmware_app_and_it_is_checked_that_it_is_on(
    app: bool, held: float, sent: list[str], wrong: str
) -> None:
    """Mellinger's was set on connection, which switched the app off."""
    vehicle = Held(held, TABLE | ({APP: TableEntry("<B", writable=True)} if app else {}))
    required = firmware_params(("locSrv.extPosStdDev=0.001",), "setpoint")
    settings = FirmwareSettings(vehicle, required)
    settings.apply()
    assert sorted(vehicle.sent) == sent
    assert (settings.refusal(), settings.difference()) == ("", wrong)


@pytest.mark.parametrize("app", [False, True])
def test_attitudes_are_flown_by_the_pid_though_full_states_were_flown_by_another_before(app: bool) -> None:
    """Mellinger's, set by a session with full states, stayed on: nothing set or checked the controller."""
    vehicle = Held(6.0 if app else 1.0, TABLE | ({APP: TableEntry("<B", writable=True)} if app else {}))
    FirmwareSettings(vehicle, firmware_params((), "setpoint")).apply()
    assert vehicle.values[CONTROLLER] == (6.0 if app else 2.0)
    settings = FirmwareSettings(vehicle, firmware_params((), "command"))
    settings.apply()
    assert (vehicle.values[CONTROLLER], settings.difference()) == (1.0, "")


def test_without_a_radio_a_link_reports_the_reason_in_one_line(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    asked = threading.Event()

    def no_dongle(*_: object) -> None:
        asked.set()
        raise OSError("Cannot find a Crazyradio Dongle")

    monkeypatch.setattr("cflib.crtp.get_link_driver", no_dongle)
    link = CflibLink("cf1", OWN_URI, {})
    assert asked.wait(ANSWER_S)
    link.close()  # once its thread has ended
    assert link.log_lines() == ["Couldn't load link driver: Cannot find a Crazyradio Dongle"]
    assert caplog.messages == []


def test_a_uri_is_opened_by_one_link_of_this_machine_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CflibLink, "keep_open", lambda _: None)
    taken = f"{OWN_URI.replace('//0/', '//[*]/')} is in use by another node on "
    for _ in range(2):
        link = CflibLink("cf1", OWN_URI, {})
        for same in (OWN_URI, OWN_URI.lower(), OWN_URI.replace("//0/", "//1/"), f"{OWN_URI}?safelink=0"):
            with pytest.raises(ValueError, match=taken):
                CflibLink("cf2", same, {})
        link.close()


def test_a_link_whose_vehicle_has_no_such_parameter_is_open_and_says_so_and_whether_it_flies(
    tmp_path: Path,
) -> None:
    crazyflies = CflibFleet(np.zeros((1, 4)))
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as endpoint:
        asked = {"locSrv.extPosStDev": 0.002, "locSrv.extQuatStdDev": 0.07}
        link = CflibLink("cf1", endpoint.uris[0], asked, str(tmp_path))
        held = crazyflies.firmware().parameters

        def is_known() -> bool:
            output = link.health()
            taken = held["locSrv.extQuatStdDev"] == pytest.approx(0.07)
            return taken and output.connected and output.own_hover is not None

        try:
            fly_until(is_known, crazyflies, endpoint)
            assert link.health().wrong.startswith("it has no parameter locSrv.extPosStDev (firmware_params)")
            fly_until(lambda: link.health().flying is False, crazyflies, endpoint)
            link.arm()
            fly_until(lambda: link.health().armed, crazyflies, endpoint)
            link.take_off(0.5, 1.0)
            fly_until(lambda: link.health().flying is True, crazyflies, endpoint)
        finally:
            link.close()


def test_a_vehicle_that_vanishes_is_lost_without_an_error_and_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    raised: list[threading.ExceptHookArgs] = []
    monkeypatch.setattr(threading, "excepthook", raised.append)
    crazyflies = CflibFleet(np.zeros((1, 4)))
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as endpoint:
        port = int(endpoint.uris[0].rpartition(":")[2])
        link = CflibLink("cf1", endpoint.uris[0], {}, str(tmp_path))

        fly_until(lambda: kept_open(link).quality == 1.0 and link.pose is not None, crazyflies, endpoint)
    try:
        until(lambda: not kept_open(link).connected)
        assert math.isnan(link.health().quality)
        assert link.pose is None  # the estimate of before its loss is not that of a vehicle found again
        again = CflibFleet(np.zeros((1, 4)))
        with CrtpEndpoint(again.fleet, port, SharedRadioParams()) as endpoint:
            fly_until(lambda: kept_open(link).quality == 1.0, again, endpoint)
    finally:
        link.close()
    assert raised == []


def kept_open(link: CflibLink) -> LinkHealth:
    """Return the health of a link after the node's periodic call."""
    link.keep_open()
    return link.health()
