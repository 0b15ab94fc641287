"""A room in simulated time in which a real node of ours flies vehicles of real firmware by the procedure.

The node stands on a StandInNode: what it publishes and calls is kept, or handed to whom it is for; its clocks
are the room's. Motion capture, filter, trajectory and controller are the blocks that fly everywhere.
"""

from collections.abc import Callable
from types import ModuleType
from typing import TypeVar

import numpy as np
import pytest
from room_node import RoomNode, Servers
from std_srvs.srv import Trigger

from cflib_fleet import Wire
from q2q_control.flight_procedure.steps import Call
from q2q_model.model_files.find_model import find_model
from q2q_model.node.reply import Reply
from q2q_model.ros.topics.plan_message import encode_plan
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, MocapFrame
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.loop.flight_blocks import BlockChoices, blocks_of
from q2q_sim.loop.room import Room
from q2q_sim.scenarios.scenario import Scenario

BOOT_TICKS = 60
"""The firmware boots within these, and arms itself."""

Made = TypeVar("Made")


class ProcedureRoom:
    """Room, blocks, and one node that flies the vehicles."""

    def __init__(
        self,
        scenario: Scenario,
        monkeypatch: pytest.MonkeyPatch,
        plan: SwarmPlan | None = None,
        *,
        auto_arming: bool = True,
    ) -> None:
        self.scenario = scenario
        self.room = Room(scenario, 0)
        params = CrtpRoomParams(start="ground", positioning="deck", auto_arming=auto_arming)
        self.fleet = fleet_in(self.room, scenario, params)
        self.blocks = blocks_of(scenario, BlockChoices("aware"), find_model(scenario.model).interaction)
        self.plan = plan or self.blocks.plan
        self.player = PlanPlayer(self.plan, -1.0, TransitParams(), wait=True)
        self._monkeypatch = monkeypatch
        self.log: list[str] = []
        """Calls of servers, in order."""
        self.height: list[Array] = []
        self.setpoint_heights: list[Array] = []
        self.steps: list[str] = []
        self.node: RoomNode | None = None
        self.mocap: Callable[[MocapFrame, int], None] = lambda *_: None
        self.speaks: set[str] = {"state", "interference", "reference_safe", "command"}
        """Topics that others publish for the node."""
        for _ in range(BOOT_TICKS):
            self.room.fly(self.fleet.fly)

    def wire(self, vehicle: int) -> Wire:
        """Return what cflib's encoders take for a vehicle's Crazyflie."""
        return Wire(self.fleet.vehicles[vehicle].handle)

    def now(self) -> float:
        """Return the room's time [s]."""
        return 100.0 + self.room.tick * TICK_S

    def clock(self, *modules: ModuleType) -> None:
        """Let modules read the room's clock."""
        for module in modules:
            self._monkeypatch.setattr(module, "monotonic", self.now)

    def trajectory(self) -> Servers:
        """Return the services of the node `trajectory`."""
        calls = {
            "wait": self.player.wait,
            "wait_landed": self.player.wait_landed,
            "transit": self.player.transit,
            "start": self.player.start,
            "hold": self.player.hold,
        }

        def server(name: str, act: Callable[[], Reply]) -> Callable[[object], object]:
            def serve(_: object) -> object:
                reply = act()
                self.log.append(f"trajectory/{name}")
                return Trigger.Response(success=reply.granted, message=reply.reason)

            return serve

        return {f"trajectory/{name}": server(name, act) for name, act in calls.items()}

    def start(
        self,
        name: str,
        given: dict[str, object],
        build: Callable[[RoomNode], Made],
        servers: Servers | None = None,
    ) -> Made:
        """Build a node in this room, and let it know of the plan that waits."""
        self.node = RoomNode(name, given, self.trajectory() | servers)
        made = build(self.node)
        if "next_plan" in self.node.takers:
            self.node.takers["next_plan"](encode_plan(self.plan, 0))
        return made

    def give(self, topic: str, signal: Signal, stamp_ns: int) -> None:
        """Hand a signal to the node, if it listens."""
        assert self.node is not None
        if topic in self.speaks and topic in self.node.takers:
            self.node.takers[topic](encode(signal, stamp_ns))

    def tick(self) -> None:
        """Let 10 ms pass."""
        seen = self.room.capture()
        stamp = seen.frame_stamp_ns
        self.mocap(seen.frame, stamp)
        state = self.blocks.mocap_filter.update(seen.frame)
        downwash = self.blocks.predictor.update(state)
        setpoint = self.player.update(seen.frame)
        self.give("state", state, stamp)
        self.give("interference", downwash, stamp)
        self.give("reference_safe", setpoint, stamp)
        if self.node is not None and "command" in self.node.takers:
            self.give("command", self.blocks.controller.update(state, setpoint, downwash), stamp)
        if self.node is not None and self.room.tick % 2 == 0:
            for period, act in self.node.timers:
                if period < 0.1:
                    act()
        for vehicle in self.fleet.vehicles:
            vehicle.handle(ECHO_REQUEST)
        self.height.append(seen.truth.pos[:, 2].copy())
        self.setpoint_heights.append(setpoint.pos[:, 2].copy())
        self.room.fly(self.fleet.fly)
        self.fleet.outgoing()

    def wait(self, seconds: float) -> None:
        """Let time pass [s]."""
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def call(self, call: Call | str, timeout: float = 40.0) -> Reply:
        """Call a service and let time pass until it answers."""
        assert self.node is not None
        service = self.node.services[call.value if isinstance(call, Call) else call]
        before = len(service.sent)
        service.call()
        left = round(timeout / TICK_S)
        while len(service.sent) == before and left:
            self.tick()
            left -= 1
        assert len(service.sent) == before + 1, f"{call}: no answer in {timeout} s: {self.node.lines[-5:]}"
        return service.sent[-1]

    def highest(self) -> float:
        """Return how high any vehicle has been [m]."""
        return float(np.max(self.height))

    def height_error(self, seconds: float) -> Array:
        """Return the rms height error of each vehicle in the last seconds [m], (n,)."""
        count = round(seconds / TICK_S)
        off = np.array(self.height[-count:]) - np.array(self.setpoint_heights[-count:])
        return np.asarray(np.sqrt((off**2).mean(axis=0)))
