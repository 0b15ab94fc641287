"""Bits of the firmware's supervisor.info, as a log block and Crazyswarm2's Status carry it."""

ARMED, CAN_FLY, FLYING, LOCKED = 2, 8, 16, 64

READY = ARMED | CAN_FLY
"""Armed, and past the supervisor's checks: for some ticks after arming a take-off is still refused."""
