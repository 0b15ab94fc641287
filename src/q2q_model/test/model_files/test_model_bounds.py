"""Models that predict more than a vehicle's air can do are refused, known ones and those at the bound not."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.envelope_network import EnvelopeNetwork, Network
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.roles import BLEND
from q2q_model.model_files.model_bounds import CLIMB, LARGEST, check_model
from q2q_model.model_files.model_file import ModelFile, decode, encode, load, save
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.vehicle.constants import CONTACT

RISING = Jet(strength=20.0, decay="exponential", decay_rate=-5.0, reference_gap=0.0, range=10.0)
"""Each of its numbers is allowed, and at 10 m it pushes by 20 exp(50) m/s^2."""


@pytest.mark.parametrize("law", [NoInteraction(), PAPER_LAW, MEASURED_LAW, MOVING_LAW])
def test_known_laws_are_allowed(law: NoInteraction | Jet) -> None:
    check_model(law)


@pytest.mark.parametrize(("share", "allowed"), [(0.999, True), (1.001, False)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_bound_is_five_g_at_contact(share: float, allowed: bool, sign: float) -> None:
    upper_part = Jet().upper_ratio * 0.5 * (1.0 - math.tanh(CONTACT / BLEND))  # of a vehicle seen as upper
    gap = CONTACT * math.tanh(CONTACT / BLEND)
    lower_part = 0.5 * (1.0 + math.tanh(CONTACT / BLEND))
    own = (lower_part - upper_part) * math.exp(-2.0 * (gap - 0.64))
    strength = sign * share * LARGEST / own
    strong = Jet(strength=strength, decay="exponential", decay_rate=2.0, reference_gap=0.64)
    if allowed:
        check_model(strong)
    else:
        with pytest.raises(
            ValueError, match=r"0\.14 m above a vehicle .* 49\.1 m/s\^2; must be at most 49\.1 \(5 g\)"
        ):
            check_model(strong)


def test_a_jet_so_slow_that_a_climb_multiplies_it_is_refused() -> None:
    times = 21.0
    slow = replace(MOVING_LAW, travel_speed=CLIMB / (times - 1.0), velocity_share=0.0, range=0.2)
    at_rest = 2.88 * math.exp(-1.32 * (CONTACT * math.tanh(CONTACT / BLEND) - 0.4))
    with pytest.raises(ValueError, match=rf"0\.14 m above a vehicle .* {times * at_rest:.3g} m/s\^2"):
        check_model(slow)


def test_a_network_is_looked_at_beside_its_axis() -> None:
    beside = np.array([[100.0, 0.0]])  # zero on the axis, 1000 m/s^2 a few centimetres beside it
    with pytest.raises(ValueError, match="at most"):
        check_model(EnvelopeNetwork(Network(beside, np.zeros(1), np.full(1, 1000.0), 0.0), _constant(0.1)))


def test_a_file_of_such_a_model_is_refused_with_what_is_allowed() -> None:
    with pytest.raises(
        ModelFileError, match=r"10\.00 m above .* 1\.04e\+23 m/s\^2; must be at most 49\.1 \(5 g\)"
    ):
        decode(encode(ModelFile(RISING)))


def test_such_a_model_is_not_written_and_the_sentence_is_that_of_loading(tmp_path: Path) -> None:
    path, known = tmp_path / "strong.q2q", ModelFile(PAPER_LAW)
    path.write_text(encode(ModelFile(RISING)))
    with pytest.raises(ModelFileError) as of_load:
        load(path)
    save(path, known)
    with pytest.raises(ModelFileError) as of_save:
        save(path, ModelFile(RISING))
    assert str(of_save.value) == str(of_load.value)
    assert load(path) == known


def test_a_source_below_that_lifts_too_much_is_named_as_below() -> None:
    lifting = Jet(strength=2.0, decay="exponential", decay_rate=-5.0, reference_gap=0.5, range=1.2)
    with pytest.raises(ValueError, match=r"1\.20 m above .* 66\.2 m/s\^2"):
        check_model(lifting)  # 2 exp(5 * 0.7)
    swapped = EnvelopeNetwork(_constant(1.0), _constant(100.0))
    with pytest.raises(ValueError, match=r"0\.14 m below"):
        check_model(swapped)


@pytest.mark.parametrize(
    ("speed", "message"),
    [
        (0.2, ""),
        (0.19, "delay is 10.5 s; must be at most 10 s"),
        (1e-9, "delay is 2e+09 s; must be at most 10 s"),
    ],
)
def test_air_that_arrives_after_more_than_10_s_is_refused(speed: float, message: str) -> None:
    slow = Jet(range=2.0, travel_speed=speed)
    if not message:
        check_model(slow)
        return
    with pytest.raises(ValueError, match=re.escape(message)):
        check_model(slow)


def _constant(push: float) -> Network:
    return Network(np.zeros((1, 2)), np.zeros(1), np.zeros(1), push)
