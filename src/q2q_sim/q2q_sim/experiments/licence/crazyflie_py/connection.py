"""Connection of Crazyswarm2's server to a vehicle: read parameters, set those of the file, start logs.

The parameters are those before the file's were set, as the server reports them (`firmware_params:
query_all_values_on_connect: true`).
"""

from collections.abc import Mapping

from q2q_sim.crtp.tables.log_toc import VARIABLES
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.experiments.licence.crazyflie_py import server_packets
from q2q_sim.experiments.licence.crazyflie_py.reports import POSE, POSE_VARIABLES, STATUS, STATUS_VARIABLES
from q2q_sim.experiments.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.experiments.licence.crazyflie_py.server_links import ServerLinks
from q2q_sim.firmware.parameters.parameter_table import TABLE

NUMBERS: Mapping[str, int] = {one.name: number for number, one in enumerate(TABLE)}
"""Number of each parameter."""
_VALUE_AT = 3
"""Place of the value in the answer to a question for a parameter."""
_VARIABLE_NUMBERS = {f"{one.group}.{one.name}": number for number, one in enumerate(VARIABLES)}


def connect(links: ServerLinks, number: int, vehicle: ServedVehicle) -> dict[str, float]:
    """Set up a vehicle; return its parameters by name, as they were before."""
    values = {name: _read(links, number, name) for name in NUMBERS}
    for name, value in vehicle.parameters:
        if name in NUMBERS:
            place = NUMBERS[name]
            links.set_up(number, server_packets.parameter_write(place, TABLE[place], value))
        else:
            print(f"[{vehicle.name}] Could not find param {name}")
    blocks = ((POSE, POSE_VARIABLES, vehicle.pose_hz), (STATUS, STATUS_VARIABLES, vehicle.status_hz))
    for block, names, frequency in blocks:
        if frequency:
            variables = [_variable(name) for name in names]
            for packet in server_packets.log_packets(block, variables, frequency):
                links.set_up(number, packet)
    return values


def _read(links: ServerLinks, number: int, name: str) -> float:
    place = NUMBERS[name]
    answer = links.set_up(number, server_packets.parameter_read(place))
    value: float = TYPES[TABLE[place].kind].layout.unpack_from(answer, _VALUE_AT)[0]
    return value


def _variable(name: str) -> tuple[int, int]:
    """Return type code and number of a log variable."""
    number = _VARIABLE_NUMBERS[name]
    return TYPES[VARIABLES[number].kind].log or 0, number
