"""Lookup of a user's controller, which is made for a vehicle type."""

from q2q_control.controller import Controller
from q2q_control.own_controller.checked_controller import CheckedController
from q2q_model.own_class import OwnClassError, error_line, own_class
from q2q_model.vehicle.constants import Vehicle


class ControllerClassError(ValueError):
    """Error for a class that is not found, cannot be made, or is no controller."""


def find_controller(name: str, vehicle: Vehicle) -> CheckedController:
    """Return a new controller of the class `module:Class`, reset, every command of which is checked.

    Args:
        name: of the class, whose only argument is the vehicle.
        vehicle: type of all vehicles that it flies.

    Raises:
        ControllerClassError: the class is not found, cannot be made, or has not the methods of Controller.
        ControllerOutputError: it cannot be reset.
    """
    try:
        found = own_class(name)
    except OwnClassError as error:
        raise ControllerClassError(f"controller {name}: {error}") from error
    try:
        made = found(vehicle)  # type: ignore[call-arg]  # of a user's class, as documented
    except (Exception, SystemExit) as error:
        raise ControllerClassError(
            f"controller {name}: {found.__name__}(vehicle) raised {error_line(error)}"
        ) from error
    if not isinstance(made, Controller):
        raise ControllerClassError(
            f"controller {name}: the class needs methods update(state, setpoint, interference) and reset()"
        )
    checked = CheckedController(made, vehicle)
    checked.reset()
    return checked
