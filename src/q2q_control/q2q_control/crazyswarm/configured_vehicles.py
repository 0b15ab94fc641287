"""Vehicles of the node `crazyswarm`, from its parameters or a `crazyflies.yaml`."""

from pathlib import Path

from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.crazyswarm.motion_capture_file import check_tracking, motion_capture_from_file
from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.radio.crazyflies_file import check_connections, crazyflies_from_document, params_set
from q2q_control.radio.link.firmware_params import firmware_params
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.signals.values import Names, check_unique
from q2q_model.signals.vehicle_name import check_vehicle_name
from q2q_model.vehicle.constants import vehicle_by_name


def vehicle_names(params: CrazyswarmParams) -> Names:
    """Return the names of the vehicles.

    Raises:
        ValueError: there are none, a name is no topic's or used twice; the file is wrong or unreadable.
    """
    if params.crazyflies:
        document = load_yaml(Path(params.crazyflies))
        check_connections(document)
        return tuple(one.name for one in crazyflies_from_document(document))
    if not params.vehicles:
        raise ValueError("no vehicles: set crazyflies:=FILE, or vehicles")
    check_unique(params.vehicles)
    for name in params.vehicles:
        check_vehicle_name(name)
    return params.vehicles


def server_vehicles(params: CrazyswarmParams) -> tuple[ServerVehicle, ...]:
    """Return the vehicles without a report, with the firmware parameters that they must have."""
    vehicle, required = vehicle_by_name(params.vehicle, params.firmware), firmware_params((), params.mode)
    document = load_yaml(Path(params.crazyflies)) if params.crazyflies else None
    return tuple(
        ServerVehicle(name, vehicle, required, _params_of_file(document, name, params.backend))
        for name in vehicle_names(params)
    )


def poses_version(params: CrazyswarmParams) -> int:
    """Return the version of the poses, of motion_capture.yaml where one is given.

    Raises:
        ValueError: a file is wrong or cannot be read, or a vehicle's markers or dynamics are not in it.
    """
    if not params.motion_capture:
        return params.poses_version
    settings = motion_capture_from_file(params.motion_capture)
    if params.crazyflies:
        check_tracking(settings, load_yaml(Path(params.crazyflies)))
    return settings.topics.poses.version


def _params_of_file(document: object, name: str, backend: str) -> dict[str, float]:
    return {} if document is None else params_set(document, name, by_type=backend == "cpp")
