"""Parameters of the node `crazyswarm`: its vehicles, poses in and out, and what is sent."""

from dataclasses import dataclass

from q2q_control.crazyswarm.message_conversion import BACKENDS, DEFAULT_BACKEND
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class CrazyswarmParams:
    """Parameters of the node itself."""

    crazyflies: str = tunable("", "crazyflies.yaml of Crazyswarm2; empty: `vehicles` is used", read_only=True)
    vehicles: tuple[str, ...] = tunable((), "names of the vehicles", read_only=True)
    poses_in: str = tunable("/poses", "topic of the poses of motion capture; empty: none", read_only=True)
    poses_out: str = tunable(
        "", "topic of the filtered poses for Crazyswarm2's server; empty: not published", read_only=True
    )
    mode: str = tunable(
        "setpoint",
        "setpoints sent to the vehicles: full states (setpoint), or attitude and thrust (command)",
        choices=("setpoint", "command"),
        read_only=True,
    )
    aware: bool = tunable(True, "with mode setpoint: compensate the predicted downwash", read_only=True)  # noqa: FBT003
    backend: str = tunable(
        DEFAULT_BACKEND,
        "backend of Crazyswarm2's server, which determines the signs of cmd_vel_legacy",
        choices=BACKENDS,
        read_only=True,
    )
    vehicle: str = tunable(
        "crazyflie_2_0", "vehicle type, whose constants convert newtons to PWM", read_only=True
    )
    firmware: str = tunable(
        STOCK, "firmware of the vehicles, which determines thrust per PWM", choices=FIRMWARES, read_only=True
    )
    poses_version: int = tunable(
        1,
        "message type of poses_in, if `motion_capture` is empty: 1 is NamedPoseArray, 2 NamedPoseArrayV2",
        low=1,
        high=2,
        read_only=True,
    )
    motion_capture: str = tunable(
        "",
        "motion_capture.yaml of Crazyswarm2, whose version of the poses is used; empty: "
        "`poses_version` is used",
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds, and a topic that would feed itself."""
        check_bounds(self)
        if self.poses_in and self.poses_in == self.poses_out:
            raise ValueError(
                f"poses_in and poses_out are both {self.poses_in}: frames would loop forever; give different "
                "topics"
            )
