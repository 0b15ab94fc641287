"""Delay of poses, time and voltage limits of q2q_control.radio.pilot."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable


@dataclass(frozen=True, slots=True)
class RadioPilotParams:
    """Limits after which arming has failed, and after which a vehicle levels, lands or stops."""

    # camera, filter and radio of Crazyswarm: 26 ms to the actuators (Preiss et al., ICRA 2017)
    pose_delay_s: float = tunable(
        0.02,
        "delay from capture to the onboard estimate; poses are extrapolated by it before they are sent",
        unit="s",
        low=0.0,
        high=0.1,
    )

    arm_s: float = tunable(
        2.0, "time after which the arming of a vehicle has failed", unit="s", low=0.1, high=30.0
    )
    voltage_land: float = tunable(
        3.2, "battery voltage below which a vehicle is landed", unit="V", low=0.0, high=20.0
    )
    voltage_land_s: float = tunable(
        2.0, "time below voltage_land after which a vehicle is landed", unit="s", low=0.0, high=60.0
    )
    command_timeout_level_s: float = tunable(
        0.04, "time without a command after which a vehicle is levelled", unit="s", low=0.01, high=0.5
    )
    command_timeout_land_s: float = tunable(
        1.0, "time without a command after which a vehicle is landed", unit="s", low=0.01, high=60.0
    )
    command_timeout_stop_s: float = tunable(
        5.0,
        "time without a command after which the motors of a vehicle that lands without measurements "
        "are stopped",
        unit="s",
        low=0.01,
        high=120.0,
    )

    def __post_init__(self) -> None:
        """Check the bounds, and that the timeouts rise."""
        check_bounds(self)
        level, land, stop = (
            self.command_timeout_level_s,
            self.command_timeout_land_s,
            self.command_timeout_stop_s,
        )
        if not level <= land <= stop:
            raise ValueError(
                f"command_timeout_level_s {level}, command_timeout_land_s {land}, command_timeout_stop_s "
                f"{stop}; must satisfy command_timeout_level_s <= command_timeout_land_s <= "
                "command_timeout_stop_s"
            )
