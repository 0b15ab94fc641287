"""Parameters of the node `radio`: its vehicles, what is sent, and the firmware parameters to set."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class RadioNodeParams:
    """Parameters of the node itself."""

    crazyflies: str = tunable(
        "",
        "crazyflies.yaml of Crazyswarm2, whose firmware_params are set, too; empty: `vehicles` and `uris`",
        read_only=True,
    )
    vehicles: tuple[str, ...] = tunable((), "names of the vehicles", read_only=True)
    uris: tuple[str, ...] = tunable((), "URIs of the vehicles, in the order of `vehicles`", read_only=True)
    mode: str = tunable(
        "command",
        "packets sent: attitude and thrust (command), or full states (setpoint)",
        choices=("command", "setpoint"),
        read_only=True,
    )
    aware: bool = tunable(True, "compensate the predicted downwash in full states", read_only=True)  # noqa: FBT003
    places: bool = tunable(True, "send vehicles their poses from `state`", read_only=True)  # noqa: FBT003
    vehicle: str = tunable("crazyflie_2_0", "vehicle whose constants convert newtons to PWM", read_only=True)
    firmware: str = tunable(
        STOCK, "firmware of the vehicles, which sets thrust per PWM", choices=FIRMWARES, read_only=True
    )
    firmware_params: tuple[str, ...] = tunable(
        (),
        "firmware parameters to set once connected, each `group.name=value`; they override `crazyflies`",
        read_only=True,
    )
    toc_cache: str = tunable(
        "", "folder for the vehicles' tables of contents, which shorten later connections", read_only=True
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
