"""A dry run of the node `radio` that connects to a vehicle which another client flies."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.localization import Localization
from link_waits import fly_until

from cflib_fleet import CflibFleet
from q2q_control.radio.link.cflib_link import FLOWN, CflibLink
from q2q_control.radio.link.firmware_params import CONTROLLER, MELLINGER, PID
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams

HEIGHT = 0.5
"""Height at which the other client lets its vehicle hover [m]."""
HERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Hover:
    """Vehicle that hovers by another client, and the link of a dry run to it."""

    crazyflies: CflibFleet
    endpoint: CrtpEndpoint
    other: HighLevelCommander
    link: CflibLink

    @property
    def controller(self) -> float:
        """Return the controller that the vehicle flies by."""
        return float(self.crazyflies.firmware().parameters[CONTROLLER])


@pytest.fixture
def hover(tmp_path: Path) -> Iterator[Hover]:
    """Yield a vehicle that hovers when the link to it is opened."""
    crazyflies = CflibFleet(np.zeros((1, 4)))
    crazyflies.fly(1.0)
    other = HighLevelCommander(crazyflies.wire())
    other.takeoff(HEIGHT, 1.0)
    crazyflies.fly(3.0)
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as endpoint:
        link = CflibLink("cf1", endpoint.uris[0], {CONTROLLER: MELLINGER}, str(tmp_path), dry_run=True)
        fly_until(lambda: link.health().flying is True and link.pose is not None, crazyflies, endpoint)
        yield Hover(crazyflies, endpoint, other, link)
        link.close()


def test_a_dry_run_reports_a_vehicle_that_flies_and_leaves_it_in_the_air(
    hover: Hover, monkeypatch: pytest.MonkeyPatch
) -> None:
    poses: list[object] = []
    monkeypatch.setattr(Localization, "send_extpos", lambda _, pos: poses.append(pos))
    hover.link.send_external_pose(HERE, None)
    assert hover.link.health().wrong == FLOWN
    assert hover.link.log_lines() == [FLOWN]  # once, though it was logged in every period
    hover.link.close()  # sends what waits
    hover.crazyflies.fly(3.0)
    assert poses == []
    assert hover.controller == PID
    assert hover.crazyflies.pos()[2] == pytest.approx(HEIGHT, abs=0.05)


def test_a_dry_run_sets_the_parameters_once_the_vehicle_has_landed(hover: Hover) -> None:
    hover.other.land(0.0, 1.0)
    fly_until(lambda: hover.link.health().wrong == "", hover.crazyflies, hover.endpoint)
    assert hover.crazyflies.pos()[2] == 0.0
    assert hover.controller == MELLINGER


def test_a_dry_run_can_stop_the_motors_of_a_vehicle_that_another_client_flies(hover: Hover) -> None:
    hover.link.cut()
    fly_until(lambda: hover.link.health().locked, hover.crazyflies, hover.endpoint)
    hover.crazyflies.fly(1.0)
    assert hover.crazyflies.pos()[2] == 0.0
