"""Warnings of cflib that a node shows, and those that say nothing about a vehicle."""

import warnings
from types import SimpleNamespace

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
from cflib.crazyflie.supervisor import Supervisor

from q2q_control.radio.link.cflib_library import new_crazyflie


@pytest.mark.parametrize(("version", "shown"), [(-1, False), (11, True), (12, False)])
def test_only_a_connected_vehicle_can_have_old_firmware(version: int, shown: bool) -> None:
    """Without a connection, cflib takes version -1 for old firmware."""
    sent: list[object] = []
    platform = SimpleNamespace(get_protocol_version=lambda: version)
    vehicle = SimpleNamespace(platform=platform, send_packet=sent.append, add_port_callback=lambda *_: None)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        new_crazyflie("")
        Supervisor(vehicle).send_emergency_stop()
    assert (len(sent), bool(caught)) == (1, shown)
