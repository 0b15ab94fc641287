"""Flights by RPYT setpoints through the node `crazyswarm`: their thrust is 0 until one has thrust 0."""

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_server import by_bridge, said_in_order
from procedure_vehicles import SHORT, SHORT_ENDS, fly_plan, land

from q2q_control.flight_procedure.steps import Call

COMMANDS_ORDER = [
    "trajectory/wait_landed", "arm", "thrust 0", "notify_setpoints_stop", "takeoff",
    "trajectory/transit", "cmd_vel_legacy", "trajectory/start", "cmd_vel_legacy",
    "trajectory/transit", "cmd_vel_legacy", "notify_setpoints_stop", "land", "arm",
]  # fmt: skip


@pytest.mark.parametrize("backend", ["cpp", "cflib"])
def test_a_plan_is_flown_twice_by_rpyt_setpoints(monkeypatch: pytest.MonkeyPatch, backend: str) -> None:
    """No setpoint of thrust 0 had unlocked the thrust: vehicles fell when setpoints took over."""
    room, _ = by_bridge(monkeypatch, SHORT, mode="command", backend=backend)
    for vehicle in room.fleet.vehicles:
        vehicle.firmware.parameters.set("stabilizer.controller", 1.0)
    room.wait(1.5)
    for _ in range(2):
        fly_plan(room, *SHORT_ENDS)
        assert room.height_error(3.0).max() < 0.08  # the paper's soft loop (K_p 0.81), as by radio
        land(room)
        assert said_in_order(room) == COMMANDS_ORDER


def test_rpyt_setpoints_are_refused_where_mellingers_controller_would_fly_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, _ = by_bridge(monkeypatch, SHORT, mode="command")
    room.wait(1.5)
    assert "cf1: its stabilizer.controller is 2, expected 1" in room.call("take_off").reason


@pytest.mark.parametrize("mode", ["setpoint", "command"])
def test_after_arming_another_client_of_the_server_can_take_off(
    monkeypatch: pytest.MonkeyPatch, mode: str
) -> None:
    """A setpoint of thrust 0 after arming overrode its take-off."""
    room, server = by_bridge(monkeypatch, SHORT, mode=mode)
    room.wait(1.5)
    assert room.call("arm").granted
    assert said_in_order(room) == ["arm"]
    server.take_off(0.8, 2.0)
    room.wait(3.0)
    assert room.height[-1].min() > 0.78


def test_a_start_by_rpyt_setpoints_unlocks_the_thrust_of_vehicles_in_the_air(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They sink by 0.26 m; where thrust 0 held for 0.1 s before the stream, they fell to the floor."""
    room, server = by_bridge(monkeypatch, SHORT, mode="command")
    for vehicle in room.fleet.vehicles:
        vehicle.firmware.parameters.set("stabilizer.controller", 1.0)
    room.wait(1.5)
    assert room.call("arm").granted
    server.take_off(0.8, 2.0)
    room.wait(3.0)
    assert room.player.transit().granted
    room.wait(2.0)
    said_in_order(room)
    assert room.call(Call.START).granted
    room.wait(3.0)
    assert np.min(room.height[-300:]) > 0.5
    assert said_in_order(room) == ["arm", "thrust 0", "cmd_vel_legacy"]
