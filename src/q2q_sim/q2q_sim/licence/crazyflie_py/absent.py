"""What has no stand-in says so in one sentence, wherever a program uses it."""

from types import ModuleType
from typing import NoReturn

NOT_PUBLIC = (
    "position", "cmdVelocityWorld", "cmdVel", "cmdStop", "stop", "setParams", "setLEDColor",
    "enableCollisionAvoidance", "disableCollisionAvoidance",
)  # fmt: skip
"""Calls of Crazyswarm1 that Crazyswarm2 has commented out."""


class Absence:
    """Attributes that are missing raise an AttributeError of one sentence."""

    public_name = ""
    """Name of the class in crazyflie_py, if it is another one."""

    def __getattr__(self, name: str) -> NoReturn:
        """Say why there is no such attribute."""
        kind = self.public_name or type(self).__name__
        if name in NOT_PUBLIC:
            raise AttributeError(f"Crazyswarm2's {kind} has no {name}: it exists in Crazyswarm1 only")
        raise AttributeError(
            f"the {kind} of a licence has no {name}: only the documented calls are emulated, not the ROS "
            "node under them"
        )


class AbsentModule(ModuleType):
    """Module of crazyflie_py that is not stood in for."""

    def __getattr__(self, name: str) -> NoReturn:
        """Say that there is none."""
        raise AttributeError(f"{self.__name__}.{name}: a licence has no such hardware; use swarm.input")
