"""Parameters of the node `crazyswarm`: its vehicles, poses in and out, and what is sent."""

from dataclasses import dataclass

from q2q_control.crazyswarm.message_conversion import BACKENDS, DEFAULT_BACKEND
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class CrazyswarmParams:
    """Parameters of the node itself."""

    crazyflies: str = tunable("", "crazyflies.yaml of Crazyswarm2; empty: `vehicles`", read_only=True)
    vehicles: tuple[str, ...] = tunable((), "names of the vehicles", read_only=True)
    poses_in: str = tunable("/poses", "topic of motion capture poses; empty: none", read_only=True)
    poses_out: str = tunable(
        "", "topic of filtered poses for Crazyswarm2's server; empty: none", read_only=True
    )
    mode: str = tunable(
        "setpoint",
        "messages sent: full states (setpoint), or attitude and thrust (command)",
        choices=("setpoint", "command"),
        read_only=True,
    )
    aware: bool = tunable(True, "compensate the predicted downwash in full states", read_only=True)  # noqa: FBT003
    backend: str = tunable(
        DEFAULT_BACKEND,
        "backend of Crazyswarm2's server, whose signs cmd_vel_legacy has",
        choices=BACKENDS,
        read_only=True,
    )
    vehicle: str = tunable("crazyflie_2_0", "vehicle whose constants convert newtons to PWM", read_only=True)
    firmware: str = tunable(
        STOCK, "firmware of the vehicles, which sets thrust per PWM", choices=FIRMWARES, read_only=True
    )
    poses_version: int = tunable(
        1,
        "version of poses_in without `motion_capture`: 2 is NamedPoseArrayV2",
        low=1,
        high=2,
        read_only=True,
    )
    motion_capture: str = tunable(
        "", "motion_capture.yaml of Crazyswarm2; empty: `poses_version`", read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds, and a topic that would feed itself."""
        check_bounds(self)
        if self.poses_in and self.poses_in == self.poses_out:
            raise ValueError(
                f"poses_in and poses_out are both {self.poses_in}: frames would circulate for ever"
            )
