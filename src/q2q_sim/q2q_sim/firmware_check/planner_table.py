"""Comparison of the high-level commander: packets in, answers and setpoints out, at 100 Hz.

The motors are off, so that the supervisor always permits flight.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_sim.firmware.commander.setpoint import Setpoint
from q2q_sim.firmware_check.bench import Bench
from q2q_sim.firmware_check.table_rows import CheckRow, CheckTable, cases, row_numbers

READY_TICKS = 20
"""Ticks until the stock build is ready to fly."""
LONGEST_MS = 65535
"""Largest value of supervisor.prefltTimeout."""
POS, VEL, ACC = ("px", "py", "pz"), ("vx", "vy", "vz"), ("ax", "ay", "az")
START = -1
"""Tick of the row with the vehicle's position."""


class PlannerDifference(NamedTuple):
    """Largest differences of the high-level commander's setpoints, and number of different answers."""

    cases: int
    max_pos_m: float
    max_vel_mps: float
    max_acc_mps2: float
    answers_differ: int


def compare_planner(table: CheckTable) -> PlannerDifference:
    """Return the largest differences over all cases of planner.csv."""
    found = [_compare(rows) for rows in cases(table)]
    worst = np.array([gaps for gaps, _ in found]).max(axis=0)
    pos, vel, acc = worst.tolist()
    return PlannerDifference(len(found), pos, vel, acc, sum(wrong for _, wrong in found))


def _compare(rows: list[CheckRow]) -> tuple[list[float], int]:
    """Return the largest differences of position, velocity, acceleration, and how many answers differ."""
    start, *rows = rows
    yaw = math.radians(float(start["yaw_deg"]))
    bench = Bench(np.array([*row_numbers(start, POS), yaw]), auto_arming=True)
    bench.firmware.parameters.set("supervisor.prefltTimeout", LONGEST_MS)
    for _ in range(READY_TICKS):
        bench.firmware.tick()
    worst, wrong, now = np.zeros(3), 0, START + 1
    for row in rows:
        for _ in range(now, int(row["tick"])):
            bench.firmware.tick()
        if row["packet"]:
            answers = bench.handle(bytes.fromhex(row["packet"]))
            wrong += [answer[4] for answer in answers] != [int(row["answer"])]
        bench.firmware.tick()
        now = int(row["tick"]) + 1
        worst = np.maximum(worst, _gaps(bench.firmware.flown, row))
    return worst.tolist(), wrong


def _gaps(flown: Setpoint, row: CheckRow) -> list[float]:
    pairs = (flown.pos, POS), (flown.vel, VEL), (flown.acc, ACC)
    return [float(np.abs(np.array(ours) - row_numbers(row, theirs)).max()) for ours, theirs in pairs]
