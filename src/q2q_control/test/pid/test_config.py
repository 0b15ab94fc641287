"""Every shipped file of gains fits the PID, says its sources, and makes a stable loop."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_control.pid.gains_file import load_gains, soft_altitude
from q2q_control.pid.pid_params import PidParams
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

FOLDER = Path(__file__).parents[2] / "config"
FILES = sorted(FOLDER.glob("pid_*.yaml"))


def test_the_papers_the_firmwares_and_tuned_gains_are_shipped():
    assert {path.stem for path in FILES} == {"pid_learned", "pid_mellinger", "pid_firmware", "pid_tuned"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_of_gains_begins_with_its_source_and_makes_a_stable_loop(path: Path):
    assert path.read_text(encoding="utf-8").startswith("# ")
    found = load_gains(str(path))
    for k_p, k_d, k_i in (
        (found.k_p_z, found.k_d_z, found.k_i_z),
        (found.k_p_xy, found.k_d_xy, found.k_i_xy),
    ):
        poles = np.roots([1.0, k_d, k_p, k_i])  # s^3 + K_d s^2 + K_p s + K_i; with K_i = 0 one pole is at 0
        assert (poles.real < 1e-12).all()


def test_the_learned_gains_are_the_defaults():
    assert load_gains("learned") == PidParams()


def test_mellingers_gains_are_the_firmwares_over_its_mass():
    found, mass = load_gains("mellinger"), 0.029
    # written with four decimals
    assert found.k_p_z * mass == pytest.approx(1.25, abs=1e-5)
    assert found.k_d_z * mass == pytest.approx(0.4, abs=1e-5)
    assert found.k_p_xy * mass == pytest.approx(0.4, abs=1e-5)


def test_the_firmwares_cascade_as_one_loop_has_the_cascades_poles():
    found = load_gains("firmware")
    c, outer, outer_i, inner, inner_i = (
        1000.0 / 65535.0 * CRAZYFLIE_2_0.full_pwm_thrust / 0.034,
        2.0,
        0.5,
        25.0,
        15.0,
    )
    # s^2 e = -c (K (P e + Z int e + s e) + I int(P e + s e)), the product of integrals left out
    cascade = [1.0, c * inner, c * (inner * outer + inner_i), c * (inner_i * outer + inner * outer_i)]
    assert np.allclose([1.0, found.k_d_z, found.k_p_z, found.k_i_z], cascade, rtol=1e-3)  # three decimals


@pytest.mark.parametrize(("text", "said"), [
    ("", "must have one node (or /**) with ros__parameters"),
    ("k_p_z: 10.0\n", "must have one node (or /**) with ros__parameters"),
    ("/**:\n  ros__parameters: 3\n", "expected a mapping with k_p_z"),
    ("pid:\n  ros__parameters: {k_pz: 10.0}\n", "unknown key 'k_pz'; did you mean k_p_z?"),
    ("pid:\n  ros__parameters: {k_p_z: ten}\n", "k_p_z = 'ten'; must be a number"),
    ("pid:\n  ros__parameters: {k_p_z: 1000.0}\n", "k_p_z = 1000.0; must be in [0.0, 200.0]"),
])  # fmt: skip
def test_a_file_that_is_none_of_the_pids_is_refused_by_name(tmp_path: Path, text: str, said: str):
    (tmp_path / "mine.yaml").write_text(text)
    with pytest.raises(ValueError, match=re.escape(said)) as refused:
        load_gains(str(tmp_path / "mine.yaml"))
    assert "mine.yaml" in str(refused.value)


def test_unknown_gains_are_answered_with_those_that_there_are():
    with pytest.raises(
        ValueError, match="no gains 'tune': give one of firmware, learned, mellinger, tuned, or"
    ):
        load_gains("tune")


def test_who_flies_by_the_papers_altitude_loop_is_warned_and_nobody_else():
    warning = soft_altitude(load_gains("learned"))
    assert warning.startswith("k_p_z = 0.81073, k_i_z = 0: a thrust error of 1 % is 0.12 m of height; ")
    assert not any(map(soft_altitude, map(load_gains, ("tuned", "firmware", "mellinger"))))
    assert "is inf m of height" in soft_altitude(replace(PidParams(), k_p_z=0.0))
    assert soft_altitude(replace(PidParams(), k_p_z=10.0)) == ""
