"""Parameters set in a vehicle's firmware through cflib, and read back."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from q2q_control.radio.link.firmware_params import TableEntry, first_difference, required_with_app, unsettable
from q2q_model.vehicle.hover_thrust import OWN_PARAMETERS, OwnHover

if TYPE_CHECKING:
    from cflib.crazyflie.param import Param


class FirmwareSettings:
    """Parameters of one vehicle: required values, and those that it holds."""

    def __init__(self, param: "Param", required: Mapping[str, float]) -> None:
        """Set `required` (q2q_control.radio.link.firmware_params) by cflib's parameters of a vehicle."""
        self._param = param
        self._params = dict(required)
        self._required = dict(required)
        self._refused: list[str] = []
        self._held: dict[str, float] = {}
        self.own_hover: OwnHover | None = None
        """What the firmware itself takes for hover thrust; None if it has no such parameters."""
        for name in self._params:
            param.add_update_callback(*name.split(".", 1), self._read_back)

    def apply(self) -> None:
        """Set the parameters, once connected, and read back what the vehicle then holds.

        An app's controller is only read.
        """
        self._held.clear()
        table = self._table()
        refused = unsettable(self._params, table)
        self._refused = list(refused.values())
        self._required = required_with_app(self._params, table)
        for name in self._params.keys() - refused.keys():
            if self._required[name] == self._params[name]:
                self._param.set_value(name, self._params[name])
            self._param.request_param_update(name)
        if table.keys() >= set(OWN_PARAMETERS):
            read = {name: float(self._param.get_value(name)) for name in OWN_PARAMETERS}
            self.own_hover = OwnHover(*(self._params.get(name, value) for name, value in read.items()))

    def refusal(self) -> str:
        """Return why a parameter cannot be set; empty if all can."""
        return self._refused[0] if self._refused else ""

    def difference(self) -> str:
        """Return the first parameter whose value differs from the required one; empty if none does."""
        return first_difference(self._required, self._held)

    def _table(self) -> dict[str, TableEntry]:
        """Return the vehicle's table of parameters."""
        return {
            f"{group}.{name}": TableEntry(element.pytype, element.get_readable_access() == "RW")
            for group, elements in self._param.toc.toc.items()
            for name, element in elements.items()
        }

    def _read_back(self, name: str, value: str) -> None:
        self._held[name] = float(value)
