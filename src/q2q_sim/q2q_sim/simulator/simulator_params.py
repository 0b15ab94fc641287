"""Parameters of the node `simulator`, and the scenario that they choose."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import VEHICLES
from q2q_model.vehicle.thrust_map import FIRMWARES
from q2q_sim.scenarios import library
from q2q_sim.scenarios.choices import WAKES
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import check_wake_or_air, with_air, with_choices, with_firmware


@dataclass(frozen=True, slots=True)
class SimulatorParams:
    """Parameters of the node."""

    scenario: str = tunable("table6", "name or file of the scenario", read_only=True)
    vehicle: str = tunable(
        "", "simulated vehicle type; empty: that of the scenario", choices=("", *VEHICLES), read_only=True
    )
    wake: str = tunable(
        "", "simulated wake; empty: that of the scenario", choices=("", *WAKES), read_only=True
    )
    air: str = tunable(
        "",
        "air model in place of wake and disturbance: a shipped name, a .air file or module:Class; "
        "empty: that of the scenario",
        read_only=True,
    )
    air_without: tuple[str, ...] = tunable((), "terms of the air model to switch off", read_only=True)
    firmware: str = tunable(
        "",
        "firmware of the vehicles, which determines thrust per PWM; empty: that of the scenario",
        choices=("", *FIRMWARES),
        read_only=True,
    )
    seed: int = tunable(0, "seed of all random draws", low=0, read_only=True)
    pace: str = tunable(
        "lockstep",
        "lockstep: time advances when the command of the tick arrives; live: 100 Hz of wall time",
        choices=("lockstep", "live"),
        read_only=True,
    )
    autostart: bool = tunable(
        default=True, description="start the flight by itself; false: when ~/start is called", read_only=True
    )
    starts_after: tuple[str, ...] = tunable(
        (), "with autostart: nodes that must be ready and connected before the flight starts", read_only=True
    )
    crtp: bool = tunable(
        default=False,
        description="let CRTP clients fly the vehicles; the topic command is not read",
        read_only=True,
    )
    resend_period_s: float = tunable(
        5.0,
        "lockstep: time without a command after which the frame is published again",
        unit="s",
        low=0.01,
        high=60.0,
        read_only=True,
    )
    command_timeout_s: float = tunable(
        120.0,
        "lockstep: time without a command after which the tick counts as missed",
        unit="s",
        low=0.01,
        high=3600.0,
        read_only=True,
    )
    """Longer than a scripted flight waits for a tick: a stalled one fails instead of flying differently."""

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def chosen_scenario(params: SimulatorParams) -> Scenario:
    """Return the scenario with the parameters' vehicle, wake, air and firmware.

    Raises:
        ValueError: no such scenario, a wrong file, or both a wake and an air.
    """
    check_wake_or_air(params.wake, params.air)
    chosen = with_choices(library.load(params.scenario), params.vehicle, params.wake)
    return with_firmware(with_air(chosen, params.air, params.air_without), params.firmware)
