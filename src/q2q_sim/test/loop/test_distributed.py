"""Distributed MPCs fly as the joint one without downwash, nearly so in it, and bear losses."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.flight import Flight
from q2q_sim.loop.closed_loop import LoopSettings, fly_blocks
from q2q_sim.loop.distributed import DistributedMpc, ExchangeParams
from q2q_sim.loop.flight_blocks import BlockChoices, Mode, blocks_of
from q2q_sim.scenarios import library

SECONDS = 5.0
"""Of `swarm2`: the upper vehicle is above the lower one at the start and at 3.8 s."""
FRESH = ExchangeParams()


@cache
def flown(exchange: ExchangeParams | None, mode: Mode = "aware", *, coupled: bool = True) -> Flight:
    """Return a flight of two vehicles by one MPC, or by one for each that exchange predictions."""
    scenario = replace(library.load("swarm2"), duration=SECONDS)
    model = PAPER_LAW if coupled else NoInteraction()
    choice = BlockChoices(mode, "mpc")
    blocks = blocks_of(scenario, choice, model)
    if exchange is not None:
        distributed = DistributedMpc(scenario, choice, model, blocks.plan, exchange)
        blocks = replace(blocks, controller=distributed)
    return fly_blocks(scenario, blocks, LoopSettings(mode))


def height_rms(flight: Flight) -> float:
    """Return the root mean square height error of all vehicles [m]."""
    return float(np.sqrt(((flight.true_pos - flight.ref_pos)[..., 2] ** 2).mean()))


def test_without_downwash_every_vehicle_flies_as_by_the_joint_controller() -> None:
    joint, alone = flown(None, coupled=False), flown(FRESH, coupled=False)
    assert alone.true_pos == pytest.approx(joint.true_pos, abs=1e-12)
    assert alone.thrust == pytest.approx(joint.thrust, abs=1e-12)


def test_with_fresh_predictions_the_height_error_is_within_a_tenth_of_the_joint_ones() -> None:
    joint, alone, ignoring = (
        height_rms(one) for one in (flown(None), flown(FRESH), flown(FRESH, "ignoring"))
    )
    assert ignoring > 2.0 * joint
    assert alone < 1.1 * joint


@pytest.mark.parametrize("exchange", [ExchangeParams(delay=10, loss=0.5), ExchangeParams(loss=1.0)])
def test_late_and_lost_predictions_are_never_worse_than_ignoring_the_downwash(
    exchange: ExchangeParams,
) -> None:
    assert height_rms(flown(exchange)) < height_rms(flown(FRESH, "ignoring"))


def test_a_network_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="loss 2"):
        ExchangeParams(loss=2.0)
