"""Texts that name vehicles stay short with a thousand of them, and count those that they do not name."""

import numpy as np
import pytest

from q2q_control.crazyswarm.pose_topics import PoseNames
from q2q_control.failsafe.phase_changes import PhaseChange, cut_reason
from q2q_control.flight_procedure.checks.flight_checks import attitude_refusal, connection_refusal, unchecked
from q2q_control.flight_procedure.observation import Observation, VehicleReport
from q2q_control.inputs.far_setpoints import distances_text
from q2q_model.counted import MOST_NAMES
from q2q_model.estimation.filter_report import FrameWarnings
from q2q_model.estimation.mocap_warnings import LASTING, MocapWarnings
from q2q_model.signals.values import CommandStatus

NAMES = tuple(f"cf{k}" for k in range(1000))
NOWHERE = np.full((len(NAMES), 3), np.nan)
OFFLINE = Observation(
    vehicles=tuple(VehicleReport(name, connected=False) for name in NAMES),
    pos=NOWHERE,
    vel=NOWHERE,
    age=np.full(len(NAMES), np.inf),
    setpoint_pos=NOWHERE,
    setpoint_vel=NOWHERE,
    setpoint_age=np.inf,
    plan=None,
    without_attitude=NAMES,
)


def lasting_warning() -> str:
    """Return the text of bodies that have been frozen for long."""
    warnings = MocapWarnings()
    for t in (0.0, 2.0 * LASTING):
        warnings.update(t, FrameWarnings(frozen=NAMES))
    return warnings.text


def unseen_warning() -> str:
    """Return the text of a thousand poses, none of which is a vehicle's."""
    names = PoseNames("/poses", ("drone",))
    names.take(NAMES)
    return names.mismatch


TEXTS = {
    "offline": connection_refusal(OFFLINE),
    "without attitude": attitude_refusal(OFFLINE),
    "unchecked battery": unchecked(OFFLINE).partition(";")[0],
    "phase": str(PhaseChange(CommandStatus.LAND, NAMES)),
    "cut": cut_reason(NAMES, emergency=False),
    "far": distances_text(dict.fromkeys(NAMES, 1.5)),
    "unseen": unseen_warning(),
    "frozen": lasting_warning(),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_text_names_the_first_vehicles_and_counts_the_others(text: str) -> None:
    assert text.count("cf") == MOST_NAMES
    assert f", and {len(NAMES) - MOST_NAMES} more" in text
