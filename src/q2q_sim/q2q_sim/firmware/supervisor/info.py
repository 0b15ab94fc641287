"""State of the supervisor in the bits of `supervisor.info`.

Source: firmware: modules/src/supervisor.c (updateLogData), at each update.
"""

from enum import IntFlag

from q2q_sim.firmware.commander.planner import MOVING, Planner, PlanState
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.firmware.supervisor.supervisor import Supervisor


class Info(IntFlag):
    """Bits of `supervisor.info`."""

    CAN_BE_ARMED = 1
    ARMED = 2
    AUTO_ARMED = 4
    CAN_FLY = 8
    FLYING = 16
    TUMBLED = 32
    LOCKED = 64
    CRASHED = 128
    PLAN_ACTIVE = 256
    """Landing included."""
    PLAN_FINISHED = 512
    PLAN_DISABLED = 1024


def supervisor_info(one: Supervisor, plan: Planner, seconds: float) -> int:
    """Return the bits at a time [s]."""
    flags = {
        Info.CAN_BE_ARMED: one.state == State.CHECKS_PASSED,
        Info.ARMED: one.armed,
        Info.AUTO_ARMED: one.auto_arming,
        Info.CAN_FLY: one.may_fly,
        Info.FLYING: one.flying,
        Info.TUMBLED: one.tumbled,
        Info.LOCKED: one.state == State.LOCKED,
        Info.CRASHED: one.crashed,
        Info.PLAN_ACTIVE: plan.state in MOVING,
        Info.PLAN_FINISHED: plan.finished(seconds),
        Info.PLAN_DISABLED: plan.state == PlanState.DISABLED,
    }
    return sum(int(bit) for bit, holds in flags.items() if holds)
