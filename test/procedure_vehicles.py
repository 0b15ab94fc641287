"""Rooms whose vehicles `radio` flies over cflib's encoders, and whole flights by the procedure."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from cflib.crazyflie.commander import Commander
from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.localization import Localization
from cflib.crazyflie.supervisor import Supervisor
from procedure_room import ProcedureRoom

from q2q_control.flight_procedure.steps import Call, Step
from q2q_control.flight_procedure.supervisor_info import READY
from q2q_control.radio import radio_vehicles
from q2q_control.radio.link.firmware_params import first_difference
from q2q_control.radio.link.vehicle_link import CflibSender, LinkHealth, OnboardPose
from q2q_control.ros import procedure_services, radio_topics, radio_wiring
from q2q_control.ros.radio_wiring import RadioNode
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.supervisor.info import Info
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

SCENARIO = "table6"
NAMES = ("cf1", "cf2")
SHORT = minimum_snap_plan(
    [
        VehicleWaypoints("cf1", (Waypoint(0.0, (0.0, 0.0, 0.8)), Waypoint(3.0, (0.0, 0.0, 1.0)))),
        VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, 2.0, 1.0)), Waypoint(3.0, (0.0, 1.5, 1.0)))),
    ]
)
"""A plan of 3 s."""
WRONG = {
    Step.CHECKED: (Call.FLY, Call.HOLD, Call.LAND),
    Step.HOVER: (Call.TAKE_OFF, Call.START, Call.HOLD),
    Step.FLIGHT: (Call.TAKE_OFF, Call.START, Call.FLY),
    Step.HOLD: (Call.TAKE_OFF, Call.START, Call.HOLD),
}
"""Calls at the wrong time: what each step in which vehicles wait or follow the plan refuses."""


@dataclass(frozen=True)
class Link(CflibSender):
    """cflib's encoders on a simulated vehicle, and the vehicle's own word on its health."""

    firmware: Firmware
    params: Mapping[str, float]
    """What is set once connected."""
    reported: dict[str, object] = field(default_factory=dict)
    """What is reported in place of the truth."""

    @property
    def pose(self) -> OnboardPose:
        """Return the true pose as the vehicle's estimate."""
        x, y, z = self.firmware.rows.pos.tolist()
        return OnboardPose((x, y, z), (0.0, 0.0, 0.0, 1.0))

    def health(self) -> LinkHealth:
        """Return what the vehicle reports of itself."""
        bits = self.firmware.info
        truth = LinkHealth(
            connected=True,
            volt=self.firmware.battery.volt,
            armed=bits & READY == READY,
            locked=bool(bits & Info.LOCKED),
            flying=bool(bits & Info.FLYING),
            onboard=self.pose.pos,
            wrong=first_difference(
                self.params, {name: float(self.firmware.parameters[name]) for name in self.params}
            ),
            own_hover=OwnHover(*(float(self.firmware.parameters[name]) for name in OWN_PARAMETERS)),
        )
        return replace(truth, **self.reported)

    def keep_open(self) -> None:
        """Stay open."""

    def log_lines(self) -> list[str]:
        """Return nothing: the vehicle logs nothing."""
        return []

    def close(self) -> None:
        """End."""


@dataclass
class Flown:
    """A room, and the links by which `radio` flies its vehicles."""

    room: ProcedureRoom
    links: dict[str, Link] = field(default_factory=dict)


def by_radio(
    monkeypatch: pytest.MonkeyPatch,
    plan: SwarmPlan | None = None,
    scenario: Scenario | None = None,
    **given: object,
) -> Flown:
    """Return a room whose vehicles `radio` flies over cflib's encoders."""
    room = ProcedureRoom(scenario or library.load(SCENARIO), monkeypatch, plan, auto_arming=False)
    flown, names = Flown(room), room.scenario.names

    def link(name: str, _: str, params: Mapping[str, float], __: str, **___: bool) -> Link:
        row = names.index(name)
        wire, firmware = room.wire(row), room.fleet.vehicles[row].firmware
        for parameter, value in params.items():
            firmware.parameters.set(parameter, value)
        parts = Commander(wire), HighLevelCommander(wire), Localization(wire), Supervisor(wire)
        return flown.links.setdefault(name, Link(*parts, firmware, params))

    monkeypatch.setattr(radio_vehicles, "CflibLink", link)
    monkeypatch.setattr(radio_topics.RadioTopics, "other_radios", lambda _: "")
    monkeypatch.setattr(radio_topics.RadioTopics, "publish", lambda *_: None)
    room.clock(radio_wiring, procedure_services)
    uris = tuple(f"udp://127.0.0.1:{19850 + k}" for k in range(len(names)))
    vehicle = room.scenario.vehicle.name
    room.start("radio", {"vehicles": names, "uris": uris, "vehicle": vehicle, **given}, RadioNode, {})
    return flown


def refused(room: ProcedureRoom, step: Step) -> None:
    """Make every call at the wrong time of a step; each is refused at once, with the step's name."""
    for call in WRONG[step]:
        reply = room.call(call, timeout=0.0)
        assert not reply.granted
        assert f"the step is {step.value}" in reply.reason


TABLE6_ENDS, SHORT_ENDS = (50.0, [1.5, 2.0]), (3.0, [1.0, 1.0])
"""Duration [s] of a plan and the heights [m] at its end."""


def fly_plan(room: ProcedureRoom, duration: float, heights: list[float]) -> None:
    """Fly a plan from the ground to its end, with every call at the wrong time on the way."""
    refused(room, Step.CHECKED)
    assert room.call(Call.TAKE_OFF).granted, room.node.lines[-5:]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
    refused(room, Step.HOVER)
    fly = room.call(Call.FLY)
    assert (fly.granted, fly.reason) == (True, f"the plan has started and takes {duration} s")
    room.wait(0.5 * duration)
    refused(room, Step.FLIGHT)
    room.wait(0.5 * duration + 1.0)
    refused(room, Step.HOLD)
    np.testing.assert_allclose(room.height[-1], heights, atol=0.1)


def land(room: ProcedureRoom) -> None:
    """Land, and see vehicles on the ground, disarmed and checked again."""
    reply = room.call(Call.LAND)
    assert reply.granted
    assert "; disarmed" in reply.reason
    assert not any(one.firmware.supervisor.armed for one in room.fleet.vehicles)
    assert room.height[-1].max() < 0.02
    assert room.node.lines[-1] == "step checked" or room.wait(1.1) is None
