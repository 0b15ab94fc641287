"""The residual of a plan with risk grows with the push at least as its model states."""

from dataclasses import replace

import pytest
from scipy.stats import norm

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.downwash.jet import MOVING_LAW
from q2q_model.downwash.scaled_jet import CRAZYFLIE, SCALING_STD, QuadrotorSize, scaled_jet
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import ModelFile
from q2q_planner.offline.zones.risk_zone import RiskParams, RiskTube, largest_push
from q2q_planner.tools.risk_options import residual_of

OWN = ResidualProcess(floor=0.2, slope=0.05)


@pytest.mark.parametrize("hold", [2.1, 3.1, 5.5])
def test_the_growth_of_a_scaled_jets_deviation_counts_in_a_plan_and_its_floor_does_not(hold: float) -> None:
    """With the probability promised, push plus residual and the error of scaling stay below the hold."""
    jet = scaled_jet(MOVING_LAW, CRAZYFLIE, QuadrotorSize(0.067, 0.033))
    params = RiskParams(0.01, hold, RiskTube(0.1, 0.05, 0.005))
    assert jet.std_floor > REAL_FLIGHTS.floor
    push = largest_push(params, residual_of(ModelFile(jet)))
    assert push < largest_push(params, REAL_FLIGHTS)
    error = REAL_FLIGHTS.floor + max(jet.relative_std, SCALING_STD) * push
    assert norm.sf((hold - push) / error) == pytest.approx(0.005, rel=1e-6)


@pytest.mark.parametrize("name", ["paper_law", "measured_law", "moving_law"])
def test_shipped_laws_have_the_residual_of_real_flights(name: str) -> None:
    assert residual_of(find_model(name)) == REAL_FLIGHTS


def test_a_residual_of_the_models_own_is_taken_as_it_is() -> None:
    uncertain = replace(MOVING_LAW, relative_std=0.5)
    assert residual_of(ModelFile(uncertain, residual=OWN)) == OWN
