"""A receding-horizon controller on point masses in given air, for tests."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from resting_signals import resting_setpoint, resting_state

from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.interaction_model import InteractionModel, pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import (
    Array,
    Interference,
    Names,
    SwarmState,
)
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

DT = 0.01
"""The house's tick [s]."""
IDEAL = MpcParams(latency=0.0, thrust_limited=True)
"""For a plant without latency, lag and offset."""
PAIR = ("cf1", "cf2")


@dataclass
class Air:
    """Move vehicles along z only: thrust, downwash, and what the controller does not know."""

    preview: SampledPreview
    latency: int = 0
    """Ticks from a command to its effect."""
    gain: float = 1.0
    """Share of the thrust that rotors give."""
    wake: InteractionModel = PAPER_LAW

    def fly(
        self, mpc: Mpc, ticks: int, spoil: Callable[[int, SwarmState], SwarmState] | None = None
    ) -> tuple[Array, Array]:
        """Return the height errors [m] and thrusts [N], (ticks, n)."""
        names, samples = self.preview.names, self.preview.samples
        n = len(names)
        pos, vel = samples[:, 0, :3].copy(), samples[:, 0, 3:6].copy()
        acting = [np.full(n, TEXTBOOK_065.hover_thrust)] * self.latency
        errors, thrusts = [], []
        for k in range(ticks):
            state, setpoint, downwash = signals(k * DT, names, pos, vel, samples[:, k])
            downwash = replace(downwash, acc=self.downwash(pos))
            command = mpc.update(state if spoil is None else spoil(k, state), setpoint, downwash)
            acting.append(command.thrust)
            lift = self.gain * acting.pop(0) / TEXTBOOK_065.mass - GRAVITY
            for _ in range(2):
                acc = self.downwash(pos)[:, 2] + lift
                pos[:, 2] += 0.5 * DT * vel[:, 2] + 0.125 * DT**2 * acc
                vel[:, 2] += 0.5 * DT * acc
            pos[:, :2], vel[:, :2] = samples[:, k + 1, :2], samples[:, k + 1, 3:5]
            errors.append(pos[:, 2] - samples[:, k + 1, 2])
            thrusts.append(command.thrust)
        return np.array(errors), np.array(thrusts)

    def downwash(self, pos: Array) -> Array:
        """Return every vehicle's downwash, (n, 3)."""
        total = np.zeros_like(pos)
        for i in range(len(pos)):
            for j in range(len(pos)):
                if i != j:
                    rel = pos[j] - pos[i]
                    total[i] += self.wake.acceleration(rel, pairs_at_rest(rel))
        return total


def signals(t: float, names: Names, pos: Array, vel: Array, ref: Array):
    """Return state, setpoint and downwash of zero."""
    n = len(names)
    zero, flag = np.zeros((n, 3)), np.zeros(n, np.uint8)
    state = resting_state(t, names, pos.copy(), vel=vel.copy())
    setpoint = resting_setpoint(t, names, ref[:, :3], vel=ref[:, 3:6], acc=ref[:, 6:9])
    return state, setpoint, Interference(t, names, zero, zero, flag)


def pass_over(speed: float = 0.25, start: float = 1.0, gap: float = 0.5) -> SampledPreview:
    """Return cf1 hovering and cf2 flying over it from y = start [m] at a speed [m/s]."""
    t = np.arange(0.0, 12.0, DT)
    samples = np.zeros((2, t.size, 9))
    samples[0, :, 2] = 1.5
    samples[1, :, 1], samples[1, :, 2], samples[1, :, 4] = start - speed * t, 1.5 + gap, -speed
    return SampledPreview(PAIR, 0.0, DT, samples)


def first_tick(preview: SampledPreview, k: int = 0):
    """Return the signals of vehicles on their references at tick k."""
    at = preview.samples[:, k]
    return signals(k * DT, preview.names, at[:, :3], at[:, 3:6], at)


def hover(names: Names = ("cf1",)) -> SampledPreview:
    samples = np.zeros((len(names), 1200, 9))
    samples[:, :, 1] = 3.0 * np.arange(len(names))[:, None]
    samples[:, :, 2] = 1.0
    return SampledPreview(names, 0.0, DT, samples)


def controller(params: MpcParams, preview: SampledPreview, model: InteractionModel = PAPER_LAW) -> Mpc:
    return Mpc(params, TEXTBOOK_065, model, MpcSetup(preview=preview))


def rms(errors: Array) -> Array:
    return np.sqrt((errors**2).mean(axis=0))
