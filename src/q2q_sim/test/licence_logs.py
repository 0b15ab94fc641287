"""Flights of a licence that are made up: vehicles that hover, and one that falls."""

from dataclasses import replace

import numpy as np

from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import Asked, ClientCommand, CommandKind
from q2q_sim.licence.room.licence_log import LicenceLog, ProgramEnd
from q2q_sim.licence.room.trials import LicenceTrial
from q2q_sim.licence.rules.licence_limits import LicenceLimits

LIMITS = LicenceLimits(half_room=(3.0, 2.2))
TICKS = 1000
UP = slice(200, 800)
"""Ticks in which the vehicles hover."""


def command(t: float, kind: CommandKind, words: str, **more: object) -> ClientCommand:
    """Return a command of line 7 to the first vehicle."""
    return ClientCommand(t, 0, replace(Asked(kind, words), **more), line=7)


def hover(count: int = 1) -> LicenceLog:
    """Return a sound flight: vehicles 1 m apart rise slowly to 1 m, hover, and land slowly."""
    t = 0.01 * np.arange(1, TICKS + 1)
    height = np.interp(t, [0.0, 1.0, 3.0, 7.0, 9.0, 10.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    pos = np.zeros((TICKS, count, 3))
    pos[..., 2] = height[:, None]
    pos[..., 1] = np.arange(count)
    running = pos[..., 2] > 0.0
    asked = [replace(command(1.0, CommandKind.PLAN, "takeoff"), vehicle=row) for row in range(count)]
    return LicenceLog(
        uris=tuple(f"radio://{k}" for k in range(count)),
        trial=LicenceTrial(),
        t=t,
        pos=pos,
        vel=np.gradient(pos, 0.01, axis=0),
        quat=np.tile([0.0, 0.0, 0.0, 1.0], (TICKS, count, 1)),
        yaw_rate=np.zeros((TICKS, count)),
        thrust=np.ones((TICKS, count)),
        running=running,
        state=np.full((TICKS, count), int(State.FLYING)),
        age=np.zeros((TICKS, count)),
        commands=tuple(asked),
        opened=tuple(range(count)),
        end=ProgramEnd(9.9),
    )


def fallen(log: LicenceLog, tick: int = 500) -> LicenceLog:
    """Return a flight whose motors stop at a tick, after which the vehicle falls freely."""
    since = np.maximum(log.t - log.t[tick], 0.0)
    pos, vel = log.pos.copy(), log.vel.copy()
    height = np.minimum(pos[:, 0, 2], 1.0 - 0.5 * 9.81 * since**2)
    pos[:, 0, 2] = np.where(since > 0.0, np.maximum(height, 0.0), pos[:, 0, 2])
    vel[:, 0, 2] = np.where((since > 0.0) & (pos[:, 0, 2] > 0.0), -9.81 * since, 0.0)
    running = log.running.copy()
    running[tick:, 0] = False
    return replace(log, pos=pos, vel=vel, running=running)
