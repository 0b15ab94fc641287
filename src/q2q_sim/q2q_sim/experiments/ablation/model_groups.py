"""Groups of vehicles in one room, each with predictor, controller and model of its own.

A group sees its own vehicles only: groups are out of reach of each other's downwash.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import (
    Interference,
    Names,
    Rows,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
)
from q2q_sim.loop.command_gate import joined_command
from q2q_sim.loop.flight_blocks import Blocks


@dataclass(frozen=True, slots=True)
class ModelGroup:
    """Vehicles whose blocks know the same model."""

    rows: Rows
    """Of the room's vehicles, rising."""
    blocks: Blocks


class GroupedController:
    """Controller of all groups of a room; takes signals of all vehicles in the order of `names`."""

    def __init__(self, names: Names, groups: Sequence[ModelGroup]) -> None:
        self._names, self._groups = names, groups

    def reset(self) -> None:
        """Forget all memory."""
        for group in self._groups:
            group.blocks.predictor.reset()
            group.blocks.controller.reset()

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; of `interference` only matters whether there is one."""
        commands = []
        for group in self._groups:
            own = of_vehicles(state, group.rows)
            downwash = None if interference is None else group.blocks.predictor.update(own)
            commands.append(group.blocks.controller.update(own, of_vehicles(setpoint, group.rows), downwash))
        return joined_command(self._names, commands)

    def sense(self, imu: SwarmImu) -> None:
        """Take the accelerometers of a tick."""
        for group in self._groups:
            group.blocks.sense(of_vehicles(imu, group.rows))
