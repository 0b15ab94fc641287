"""Results of every comparison against the tolerances in the tables' README."""

from dataclasses import dataclass
from typing import NamedTuple

from q2q_sim.firmware_check.controller_table import ControllerDifference, compare_controllers
from q2q_sim.firmware_check.motor_tables import (
    CompensationDifference,
    MixerDifference,
    compare_compensation,
    compare_mixer,
)
from q2q_sim.firmware_check.planner_table import PlannerDifference, compare_planner
from q2q_sim.firmware_check.supervisor_table import SupervisorDifference, compare_supervisor
from q2q_sim.firmware_check.table_rows import CheckTable


@dataclass(frozen=True, slots=True)
class Tables:
    """Answers of the real firmware."""

    controllers: CheckTable
    planner: CheckTable
    supervisor: CheckTable
    mixer: CheckTable
    compensation: CheckTable


class FirmwareVerdict(NamedTuple):
    """Differences, table by table."""

    controllers: ControllerDifference
    planner: PlannerDifference
    supervisor: SupervisorDifference
    mixer: MixerDifference
    compensation: CompensationDifference


class ToleranceCheck(NamedTuple):
    """One difference with its tolerance."""

    name: str
    value: float
    allowed: float

    @property
    def within(self) -> bool:
        """Return whether the difference is within its tolerance; NaN is not."""
        return self.value <= self.allowed


def compare(tables: Tables) -> FirmwareVerdict:
    """Return the differences between the emulation and the tables."""
    return FirmwareVerdict(
        compare_controllers(tables.controllers),
        compare_planner(tables.planner),
        compare_supervisor(tables.supervisor),
        compare_mixer(tables.mixer),
        compare_compensation(tables.compensation),
    )


def tolerance_checks(verdict: FirmwareVerdict) -> tuple[ToleranceCheck, ...]:
    """Return the differences of a verdict with their tolerances."""
    controllers, planner, supervisor, mixer, compensation = verdict
    return (
        ToleranceCheck("controllers: moments and thrust [PWM]", controllers.max_pwm, 2.5),
        ToleranceCheck("controllers: motors [PWM]", controllers.max_motor_pwm, 6.0),
        ToleranceCheck("planner: position [m]", planner.max_pos_m, 1e-4),
        ToleranceCheck("planner: velocity [m/s]", planner.max_vel_mps, 1e-3),
        ToleranceCheck("planner: acceleration [m/s^2]", planner.max_acc_mps2, 1e-2),
        ToleranceCheck("planner: outputs that differ", planner.answers_differ, 0),
        ToleranceCheck("supervisor: states that differ", supervisor.states_differ, 0),
        ToleranceCheck("supervisor: info that differs", supervisor.info_differ, 0),
        ToleranceCheck("mixer: motors [PWM]", mixer.max_motor_pwm, 6.0),
        ToleranceCheck("compensation: duty [share]", compensation.max_ratio, 1e-5),
    )
