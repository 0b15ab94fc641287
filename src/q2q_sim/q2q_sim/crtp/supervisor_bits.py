"""Say what the supervisor thinks in the bits of `supervisor.info`.

Source: firmware: modules/src/supervisor.c (updateLogData).
"""

from enum import IntFlag

from q2q_sim.onboard.firmware import Firmware
from q2q_sim.onboard.planner import PlanState
from q2q_sim.onboard.supervisor_rules import State


class Info(IntFlag):
    """Name the bits."""

    CAN_BE_ARMED = 1
    ARMED = 2
    AUTO_ARMED = 4
    CAN_FLY = 8
    FLYING = 16
    TUMBLED = 32
    LOCKED = 64
    CRASHED = 128
    PLAN_ACTIVE = 256
    PLAN_FINISHED = 512


def supervisor_info(firmware: Firmware) -> int:
    """Return the bits of this moment."""
    one, plan = firmware.supervisor, firmware.planner
    flags = {
        Info.CAN_BE_ARMED: one.state == State.CHECKS_PASSED,
        Info.ARMED: one.armed,
        Info.AUTO_ARMED: one.auto_arming,
        Info.CAN_FLY: one.may_fly,
        Info.FLYING: one.flying,
        Info.TUMBLED: one.tumbled,
        Info.LOCKED: one.state == State.LOCKED,
        Info.CRASHED: one.crashed,
        Info.PLAN_ACTIVE: plan.state == PlanState.FLYING,
        Info.PLAN_FINISHED: plan.finished(firmware.seconds),
    }
    return sum(int(bit) for bit, holds in flags.items() if holds)
