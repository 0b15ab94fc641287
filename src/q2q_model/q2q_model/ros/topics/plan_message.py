"""Conversion of a plan to its message and back, for the latched topic `plan`."""

from array import array

import numpy as np
from q2q_msgs.msg import Plan

from q2q_model.ros.topics.messages import header_at
from q2q_model.signals.cdr.cdr_format import BadMessageError
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory


def encode_plan(plan: SwarmPlan, start_ns: int) -> Plan:
    """Return the message of a plan that starts at the stamp `start_ns`."""
    order = max(one.coefficients.shape[-1] for one in plan.trajectories)
    return Plan(
        header=header_at(start_ns),
        names=list(plan.names),
        pieces=array("I", [len(one.durations) for one in plan.trajectories]),
        order=order,
        durations=array("d", np.concatenate([one.durations for one in plan.trajectories]).tobytes()),
        coefficients=array("d", b"".join(_padded(one, order) for one in plan.trajectories)),
        certified=plan.certified,
    )


def decode_plan(message: Plan) -> SwarmPlan:
    """Return the plan in a message; raise ValueError if it is not valid."""
    return SwarmPlan(tuple(message.names), decode_trajectories(message), message.certified)


def decode_trajectories(message: Plan) -> tuple[Trajectory, ...]:
    """Return the trajectory of each vehicle in a message; raise ValueError if one is not valid."""
    total = sum(message.pieces)
    if len(message.pieces) != len(message.names) or len(message.durations) != total:
        raise BadMessageError(
            f"plan of {len(message.names)} vehicles: numbers of pieces and durations do not match"
        )
    needed = total * AXES * message.order
    if len(message.coefficients) != needed:
        raise BadMessageError(f"plan has {len(message.coefficients)} coefficients; its pieces need {needed}")
    coefficients = np.array(message.coefficients).reshape(total, AXES, message.order)
    ends = np.cumsum(message.pieces)
    pieces = zip(
        np.split(np.array(message.durations), ends[:-1]), np.split(coefficients, ends[:-1]), strict=True
    )
    return tuple(Trajectory(durations, rows) for durations, rows in pieces)


def _padded(trajectory: Trajectory, order: int) -> bytes:
    missing = order - trajectory.coefficients.shape[-1]
    return np.pad(trajectory.coefficients, ((0, 0), (0, 0), (0, missing))).tobytes()
