"""Parameters of the node `crazyswarm`: its vehicles, poses in and out, and what is sent."""

from dataclasses import dataclass

from q2q_control.crazyswarm.message_conversion import BACKENDS, DEFAULT_BACKEND
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class CrazyswarmParams:
    """Parameters of the node itself."""

    crazyflies: str = tunable("", "crazyflies.yaml of Crazyswarm2; else `vehicles`", read_only=True)
    vehicles: tuple[str, ...] = tunable((), "names of the vehicles", read_only=True)
    poses_in: str = tunable("/poses", "poses of motion capture; empty is none", read_only=True)
    poses_out: str = tunable("", "filtered poses for Crazyswarm2's server; empty is none", read_only=True)
    mode: str = tunable("setpoint", "what is sent", choices=("setpoint", "command"), read_only=True)
    aware: bool = tunable(True, "setpoint: compensate the predicted downwash", read_only=True)  # noqa: FBT003
    backend: str = tunable(
        DEFAULT_BACKEND, "server that takes cmd_vel_legacy", choices=BACKENDS, read_only=True
    )
    vehicle: str = tunable("crazyflie_2_0", "vehicle constants: newtons to PWM", read_only=True)
    firmware: str = tunable(STOCK, "its thrust per PWM", choices=FIRMWARES, read_only=True)
    poses_version: int = tunable(
        1, "of poses_in without `motion_capture`: 2 is NamedPoseArrayV2", low=1, high=2, read_only=True
    )
    motion_capture: str = tunable("", "its motion_capture.yaml; else `poses_version`", read_only=True)

    def __post_init__(self) -> None:
        """Refuse values out of bounds, and a topic that would feed itself."""
        check_bounds(self)
        if self.poses_in and self.poses_in == self.poses_out:
            raise ValueError(
                f"poses_in and poses_out are both {self.poses_in}: frames would circulate for ever"
            )
