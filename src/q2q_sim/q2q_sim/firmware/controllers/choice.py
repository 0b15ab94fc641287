"""Change the controller in flight: which ones there are, and what a new one forgets.

Source: firmware: modules/src/controller/controller.c (controllerInit), controller_mellinger.c,
position_controller_pid.c (their inits), stabilizer.c: stabilizer.controller reads back what flies.

| asked | flies | forgets |
|---|---|---|
| 0, 1 | cascaded PID | position and velocity PIDs; those of attitude and rate go on |
| 2 | Mellinger | its integrals; the rates' derivative goes on |
| 3, 4, 5 | what flew before | INDI, Brescianini and Lee are not simulated: the console says so |
| above | what flew before | |
"""

from enum import IntEnum

from q2q_model.signals.values import Array
from q2q_sim.firmware.controllers.columns import I_MOMENT, I_POS, PID_ROLL, PID_WIDTH, PIDS


class FirmwareController(IntEnum):
    """Controllers that are simulated; numbers as in the firmware."""

    PID = 1
    MELLINGER = 2


AUTO_SELECT = 0
NOT_SIMULATED = {3: "INDI", 4: "Brescianini", 5: "Lee"}


def chosen(asked: int, present: FirmwareController) -> FirmwareController:
    """Return the controller that flies after `asked`."""
    if asked == AUTO_SELECT:
        return FirmwareController.PID
    return FirmwareController(asked) if asked in set(FirmwareController) else present


def refusal_of(asked: int, flown: FirmwareController) -> str:
    """Return what the vehicle says on its console when it lacks the controller `asked`, mostly nothing."""
    if asked not in NOT_SIMULATED:
        return ""
    return f"Q2Q: controller {asked} ({NOT_SIMULATED[asked]}) is not simulated, {flown.name} flies on\n"


def start_controller(flown: FirmwareController, memory: Array) -> None:
    """Clear what a controller forgets when it takes over from the row of its memory (columns)."""
    if flown == FirmwareController.PID:
        memory[PIDS : PIDS + PID_ROLL * PID_WIDTH] = 0.0
    else:
        memory[I_POS : I_MOMENT + 3] = 0.0
