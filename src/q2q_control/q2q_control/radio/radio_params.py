"""Parameters of the node `radio`: its vehicles, what is sent, and the firmware parameters to set."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class RadioNodeParams:
    """Parameters of the node itself."""

    crazyflies: str = tunable(
        "",
        "crazyflies.yaml of Crazyswarm2: vehicles, URIs and firmware_params; empty: `vehicles` and "
        "`uris` are used",
        read_only=True,
    )
    vehicles: tuple[str, ...] = tunable((), "names of the vehicles", read_only=True)
    uris: tuple[str, ...] = tunable((), "URIs of the vehicles, in the order of `vehicles`", read_only=True)
    mode: str = tunable(
        "command",
        "setpoints sent to the vehicles: attitude and thrust (command), or full states (setpoint)",
        choices=("command", "setpoint"),
        read_only=True,
    )
    aware: bool = tunable(True, "with mode setpoint: compensate the predicted downwash", read_only=True)  # noqa: FBT003
    places: bool = tunable(
        default=True,
        description="send vehicles their poses, as measured by motion capture (from `state`)",
        read_only=True,
    )
    vehicle: str = tunable(
        "crazyflie_2_0", "vehicle type, whose constants convert newtons to PWM", read_only=True
    )
    firmware: str = tunable(
        STOCK, "firmware of the vehicles, which determines thrust per PWM", choices=FIRMWARES, read_only=True
    )
    firmware_params: tuple[str, ...] = tunable(
        (),
        "firmware parameters to set on each vehicle once connected, each `group.name=value`; they "
        "override those of `crazyflies`",
        read_only=True,
    )
    toc_cache: str = tunable(
        "",
        "folder in which the vehicles' tables of contents are stored, to shorten later connections; "
        "empty: not stored",
        read_only=True,
    )
    pose_hz: float = tunable(
        10.0,
        "largest rate of <name>/onboard_pose, <name>/battery and <name>/link_quality",
        unit="Hz",
        low=0.0,
        high=10.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        if len(self.vehicles) != len(self.uris):
            raise ValueError(f"{len(self.vehicles)} vehicles and {len(self.uris)} uris: each needs its own")
