"""Time what answers CRTP clients: packets a vehicle takes, ticks a fleet flies, a client's whole connection.

References in the same run: cflib's own encoding of the same packets, and the 10 ms a tick may take.
"""

import logging
from collections.abc import Callable
from time import process_time

import numpy as np

from cflib_fleet import CflibFleet
from q2q_sim.crtp.ports.link_service import ECHO_REQUEST
from q2q_sim.crtp.udp_endpoint import CrtpEndpoint
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.link.shared_radios import SharedRadioParams
from row import Row

TICK_MS = 10.0
HOVER = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.0))
FULL_STATE = ((0.1, 0.2, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.5), (0.0, 0.0, 0.0, 1.0), 0.0, 0.0, 0.1)


def run() -> list[Row]:
    """Return the rows of this area."""
    return [*_packets(), *[_fleet(n) for n in (2, 10, 50)], _connection()]


def _cpu(act: Callable[[], object], times: int) -> float:
    """Return the CPU time of one call, the least of five rounds [s]."""
    rounds = []
    for _ in range(5):
        begin = process_time()
        for _ in range(times):
            act()
        rounds.append((process_time() - begin) / times)
    return min(rounds)


def _packets() -> list[Row]:
    from cflib.crazyflie.commander import Commander

    crazyflies = CflibFleet(np.zeros((1, 4)))
    wire = crazyflies.wire()
    encoder = Commander(wire)
    encoder.send_full_state_setpoint(*FULL_STATE)
    datagram, handle = wire.sent[-1], crazyflies.fleet.vehicles[0].handle
    encoding = _cpu(lambda: encoder.send_full_state_setpoint(*FULL_STATE), 500) - _cpu(
        lambda: handle(datagram), 500
    )
    reference = "cflib encodes the same packet"
    kinds = {"full state": datagram, "echo": ECHO_REQUEST, "garbage": b"\xac" + bytes(20)}
    rows = []
    for name, packet in kinds.items():
        took = _cpu(lambda packet=packet: handle(packet), 500)
        rows.append(Row(f"{name} packets a vehicle takes", 1.0 / took, "1/s", reference, encoding / took))
    return rows


def _fleet(vehicles: int) -> Row:
    start = np.zeros((vehicles, 4))
    start[:, 0], start[:, 2] = np.arange(vehicles), 1.0
    crazyflies = CflibFleet(start)
    each = crazyflies.hold(HOVER)
    crazyflies.fly(0.5, each)
    took_ms = _cpu(lambda: crazyflies.fly(0.01, each), 50) * 1e3
    return Row(f"tick of {vehicles} vehicles", took_ms, "ms", "the tick itself, 10 ms", TICK_MS / took_ms)


def _connection() -> Row:
    import cflib.crtp
    from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

    logging.getLogger("cflib").setLevel(logging.ERROR)
    cflib.crtp.init_drivers()
    crazyflies = CflibFleet(np.zeros((1, 4)))
    with CrtpEndpoint(crazyflies.fleet, 0, SharedRadioParams()) as endpoint:
        before = process_time()
        with SyncCrazyflie(endpoint.uris[0]) as client:
            client.wait_for_params()
            took = process_time() - before
            answers = endpoint.traffic.sent
    return Row(
        "whole connection of a cflib client, both sides", took * 1e3, "ms of CPU", f"{answers} answers"
    )
