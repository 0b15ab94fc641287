"""Change of the controller in flight: available ones, and the states that a new one resets.

Source: firmware: modules/src/controller/controller.c (controllerInit), controller_mellinger.c,
position_controller_pid.c (their inits), stabilizer.c: stabilizer.controller reads back what flies.

| requested | flies | resets |
|---|---|---|
| 0, 1 | cascaded PID | position and velocity PIDs, not those of attitude and rate |
| 2 | Mellinger | its integrals, not the derivative of the rates |
| 3, 4, 5 | the one before | INDI, Brescianini and Lee are not simulated; a console message reports it |
| above | the one before | |
"""

from enum import IntEnum

from q2q_model.signals.values import Array
from q2q_sim.firmware.controllers.columns import I_MOMENT, I_POS, PID_ROLL, PID_WIDTH, PIDS


class FirmwareController(IntEnum):
    """Simulated controllers; numbers as in the firmware."""

    PID = 1
    MELLINGER = 2


AUTO_SELECT = 0
NOT_SIMULATED = {3: "INDI", 4: "Brescianini", 5: "Lee"}


def choose(asked: int, present: FirmwareController) -> FirmwareController:
    """Return the controller after a request for `asked`."""
    if asked == AUTO_SELECT:
        return FirmwareController.PID
    return FirmwareController(asked) if asked in set(FirmwareController) else present


def refusal_of(asked: int, flown: FirmwareController) -> str:
    """Return the console message if the controller `asked` is not simulated, else nothing."""
    if asked not in NOT_SIMULATED:
        return ""
    return f"Q2Q: controller {asked} ({NOT_SIMULATED[asked]}) is not simulated, {flown.name} stays\n"


def start_controller(flown: FirmwareController, memory: Array) -> None:
    """Reset the states of a controller that takes over, in its row of memory (columns)."""
    if flown == FirmwareController.PID:
        memory[PIDS : PIDS + PID_ROLL * PID_WIDTH] = 0.0
    else:
        memory[I_POS : I_MOMENT + 3] = 0.0
