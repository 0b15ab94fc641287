"""Comparison of the supervisor: packets and accelerations in, state and `supervisor.info` out, at 25 Hz."""

from typing import NamedTuple

import numpy as np

from q2q_sim.firmware.firmware import TICK_MS
from q2q_sim.firmware.supervisor.info import Info
from q2q_sim.firmware_check.bench import Bench
from q2q_sim.firmware_check.table_rows import CheckRow, CheckTable, cases, row_numbers

ACC = ("accx", "accy", "accz")
NOT_COMPARED = Info.PLAN_FINISHED
"""Bit that depends on uninitialised memory in a vehicle that has never flown a trajectory."""


class SupervisorDifference(NamedTuple):
    """Number of rows with another state, and with another `supervisor.info` except for NOT_COMPARED."""

    cases: int
    states_differ: int
    info_differ: int


def compare_supervisor(table: CheckTable) -> SupervisorDifference:
    """Return the differences over all cases of supervisor.csv."""
    found = [_compare(rows) for rows in cases(table)]
    return SupervisorDifference(len(found), sum(one for one, _ in found), sum(two for _, two in found))


def _compare(rows: list[CheckRow]) -> tuple[int, int]:
    bench = Bench(np.zeros(4), auto_arming=bool(int(rows[0]["info"]) & Info.AUTO_ARMED))
    states = infos = now_ms = 0
    for row in rows:
        for _ in range(now_ms, int(row["time_ms"]), TICK_MS):
            bench.tick()
        bench.feel(row_numbers(row, ACC))
        for packet in filter(None, row["packets"].split("|")):
            bench.handle(bytes.fromhex(packet))
        bench.tick()
        now_ms = int(row["time_ms"]) + TICK_MS
        states += bench.firmware.supervisor.state != int(row["state"])
        infos += bool((bench.firmware.info ^ int(row["info"])) & ~NOT_COMPARED)
    return states, infos
