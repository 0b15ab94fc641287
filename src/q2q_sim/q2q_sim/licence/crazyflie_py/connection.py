"""Connection of Crazyswarm2's server to a vehicle: set the parameters of its file, start logs."""

from q2q_sim.crtp.tables.log_toc import VARIABLES
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.licence.crazyflie_py import server_packets
from q2q_sim.licence.crazyflie_py.message_fields import NUMBERS
from q2q_sim.licence.crazyflie_py.reports import POSE, POSE_VARIABLES, STATUS, STATUS_VARIABLES
from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.crazyflie_py.server_links import ServerLinks

_VARIABLE_NUMBERS = {f"{one.group}.{one.name}": number for number, one in enumerate(VARIABLES)}


def connect(links: ServerLinks, number: int, vehicle: ServedVehicle) -> None:
    """Set the parameters of a vehicle and start its logs."""
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


def _variable(name: str) -> tuple[int, int]:
    """Return type code and number of a log variable."""
    number = _VARIABLE_NUMBERS[name]
    return TYPES[VARIABLES[number].kind].log or 0, number
