"""Simulation of encounters in the height of both vehicles, many at once, and their cost.

The plant is the teacher's: its altitude axis, its downwash at the true positions, no disturbance. The cost is
the stage cost of the receding horizon on the simulated motion:

    J = mean over stages of  sum over both of  e^2 + R (u + p)^2 + S (u - a)^2

So a law and the receding horizon are compared by the cost that the latter minimises.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from q2q_control.explicit_mpc.situations import Encounters, Situations
from q2q_control.explicit_mpc.teacher import Teacher, downwash_between, solve_situations
from q2q_model.signals.values import Array

ControlPolicy = Callable[[Situations], Array]
"""Map from K situations to commands (K, 2) [m/s^2]."""
Nudges = Callable[[tuple[int, ...]], Array]
"""Map from the shape (E, 2, 3) of states to disturbances of them [SI]."""


@dataclass(frozen=True, slots=True)
class EncounterFlight:
    """Outcome of simulated encounters."""

    cost: Array
    """J of each encounter [m^2], (E,)."""
    visited: Situations
    """Every stage of every encounter."""


def teacher_policy(teacher: Teacher) -> ControlPolicy:
    """Return the receding horizon as a control policy.

    It linearises along its prediction of the stage before.
    """
    kept: list[Array] = []

    def policy(situations: Situations) -> Array:
        last = np.concatenate([kept[0][..., 1:], kept[0][..., -1:]], axis=-1) if kept else None
        found = solve_situations(situations, teacher, last)
        kept[:] = [found.errors]
        return found.inputs

    return policy


def fly_encounters(
    encounters: Encounters, policy: ControlPolicy, teacher: Teacher, nudges: Nudges = np.zeros
) -> EncounterFlight:
    """Return a flight of all encounters, each starting on its references apart from `nudges`."""
    model, (low, high) = teacher.altitude_model, teacher.bounds
    effort, jerk = model.cost.input_weight
    count = len(encounters.paths)
    states, costs, visited = nudges((count, 2, 3)), [], []
    for k in range(encounters.length):
        now = encounters.ahead(states, k)
        u = np.clip(policy(now), low, high)
        eta, _ = downwash_between(now.paths[:, :, :2], states[..., :1], teacher)
        push = eta[..., 0] + now.extra[..., 0]
        stage = states[..., 0] ** 2 + effort * (u + push) ** 2 + jerk * (u - states[..., 2]) ** 2
        costs.append(stage.sum(axis=1))
        visited.append(now)
        states = (
            states @ model.transition.T + u[..., None] * model.input_gain + push[..., None] * model.push_gain
        )
        states = states + nudges(states.shape)
    parts = (np.concatenate([getattr(one, name) for one in visited]) for name in Situations.__slots__)
    return EncounterFlight(np.mean(costs, axis=0), Situations(*parts))
