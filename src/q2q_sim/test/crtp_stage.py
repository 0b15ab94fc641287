"""Room that cflib's examples fly in: cflib is unmodified and speaks UDP to an endpoint of this process.

Its `time` is the room's.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from room_time import RoomTime, in_room_time

from cflib_fleet import CflibFleet
from q2q_sim.crtp.fleet_room import CrtpRoomParams
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.link.shared_radios import SharedRadioParams

ANSWER_S = 60.0
"""An answer that has not come by then is missing [s]."""
SPOTS = np.array([[0.0, 0.0, 0.0, 0.0], [3.0, 0.0, 0.0, 0.0], [0.0, 3.0, 0.0, 0.0], [3.0, 3.0, 0.0, 0.0]])
"""Where up to four vehicles stand: x, y, z [m], yaw [rad]."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Room that examples fly in."""

    crazyflies: CflibFleet
    clock: RoomTime
    uris: tuple[str, ...]
    cache: str

    def crazyflie(self) -> SyncCrazyflie:
        """Return a link to the first vehicle, to be opened."""
        return SyncCrazyflie(self.uris[0], cf=Crazyflie(rw_cache=self.cache))


def staged(monkeypatch: pytest.MonkeyPatch, cache: str, count: int, positioning: str) -> Iterator[Stage]:
    """Yield a room with `count` vehicles that have a positioning; cflib keeps its tables in `cache`."""
    crazyflies = CflibFleet(SPOTS[:count], build=CrtpRoomParams(positioning=positioning).build)
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as endpoint:
        clock = RoomTime(crazyflies, endpoint)
        in_room_time(clock, monkeypatch)
        cflib.crtp.init_drivers()
        yield Stage(crazyflies, clock, endpoint.uris, cache)


def log_of(name: str, period_ms: int, variables: tuple[str, ...]) -> LogConfig:
    """Return a log of floats."""
    made = LogConfig(name=name, period_in_ms=period_ms)
    for variable in variables:
        made.add_variable(variable, "float")
    return made
