"""Fleet of a room: the vehicles fly by their own firmware, the rest of the room is unchanged."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from q2q_control.onboard.native_app import compile_app
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.crtp.fleet import Fleet
from q2q_sim.crtp.start_positions import spread_start_positions
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.onboard_apps import AppConditions, OnboardApps
from q2q_sim.firmware.parameters.parameter_table import DECKS
from q2q_sim.loop.room import Room
from q2q_sim.plant.body.state_row import state_at_rest
from q2q_sim.scenarios.scenario import Scenario

_POSITIONING: dict[str, tuple[str, ...]] = {
    "deck": ("bcLighthouse4",),
    "flow": ("bcFlow2", "bcZRanger2"),
    "external": (),
}
"""Decks of each positioning method."""


@dataclass(frozen=True, slots=True)
class CrtpRoomParams:
    """Start and equipment of vehicles that wait for clients."""

    start: str = tunable(
        "ground",
        "start of the vehicles: on the ground below their first waypoint (ground), or held at it (air)",
        choices=("ground", "air"),
    )
    positioning: str = tunable(
        "deck",
        "source of the vehicles' position: a positioning deck, optical flow from their start, or "
        "poses sent by clients (external)",
        choices=("deck", "flow", "external"),
    )
    decks: tuple[str, ...] = tunable(
        ("bcFlow2", "bcZRanger2"), "decks that vehicles report in addition to that for positioning"
    )
    auto_arming: bool = tunable(
        default=True, description="let vehicles arm themselves, as the stock firmware does"
    )
    app: str = tunable(
        "", "folder written by export_app, whose app runs in the simulated firmware; empty: none"
    )
    zero_expires: bool = tunable(
        default=False,
        description="let setpoints of zero thrust expire after 0.5 s; the real firmware keeps them",
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        known = [one.last for one in DECKS]
        for deck in self.decks:
            if deck not in known:
                raise ValueError(f"unknown deck {deck!r}; choose one of {', '.join(known)}")

    @property
    def build(self) -> Build:
        """Return the build of the vehicles."""
        decks = {*self.decks, *_POSITIONING[self.positioning]}
        return Build(
            auto_arming=self.auto_arming,
            positioning_deck=self.positioning == "deck",
            flow_deck=self.positioning == "flow",
            decks=tuple(sorted(decks)),
            zero_expires=self.zero_expires,
        )


def fleet_in(room: Room, scenario: Scenario, params: CrtpRoomParams) -> Fleet:
    """Return the fleet of a room before its first tick, with the vehicles at their start.

    Raises:
        AppBuildError: the app cannot be compiled.
    """
    if params.start == "ground":
        start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])  # (n, 4)
        start[:, 2] = 0.0
        start[:, :2] = spread_start_positions(start[:, :2])
        room.swarm.state[:] = state_at_rest(start, scenario.vehicle.mass)
    return Fleet(room.swarm, scenario.vehicle, params.build, apps_in(scenario, params.app, room.seed))


def apps_in(scenario: Scenario, folder: str, seed: int) -> OnboardApps | None:
    """Return the apps of a room's vehicles, of an exported folder; None if it is empty.

    Raises:
        AppBuildError: the folder has no app, or there is no C compiler.
    """
    if not folder:
        return None
    noise = AppConditions(acc_noise=scenario.imu.acc_noise, acc_bias=scenario.imu.acc_bias)
    libraries = [compile_app(Path(folder))] * len(scenario.names)
    return OnboardApps(libraries, noise, seed)


def unflown_faults(scenario: Scenario) -> str:
    """Return which faults of a scenario do not act here, where SharedRadioParams lose packets; or nothing."""
    if all(fault.kind != "radio_loss" for fault in scenario.faults):
        return ""
    return "fault radio_loss does not act on CRTP clients: set the loss of their link"


def warm_up_firmware(scenario: Scenario) -> None:
    """Fly a temporary room by its own firmware for a tick, so that the first real tick is not slow."""
    room = Room(scenario, seed=0)
    room.fly(fleet_in(room, scenario, CrtpRoomParams()).fly)
